// The march renderer's kernels and how the mesh and the cameras lie in device memory.
#include "render/march_gpu.h"

#include "core/error.h"
#include "embedded_shaders.h"

#include <bit>
#include <cmath>

namespace tetrec {

using gpu_types::GpuView;

MarchPrograms CreateMarchPrograms(const Device& device) {
  const bool atomics = device.has_float_atomics;
  const std::vector<BindingSpec> mesh = {
      {kBindTets, Access::kTexelRead}, {kBindVertices, Access::kTexelRead},
      {kBindHull, Access::kTexelRead}, {kBindViews, Access::kRead},
      {kBindBlocks, Access::kRead},    {kBindCounters, Access::kReadWrite}};
  const auto with_mesh = [&mesh](std::vector<BindingSpec> more) {
    std::vector<BindingSpec> all = mesh;
    all.insert(all.end(), more.begin(), more.end());
    return all;
  };
  const std::vector<BindingSpec> forward =
      with_mesh({{kBindRayColors, Access::kWrite}, {kBindRayEntries, Access::kWrite}});
  const std::vector<BindingSpec> backward = with_mesh({{kBindRayColors, Access::kRead},
                                                       {kBindRayEntries, Access::kRead},
                                                       {kBindRayGradients, Access::kRead},
                                                       {kBindVertexGradients, Access::kReadWrite}});
  const std::vector<BindingSpec> score = with_mesh({{kBindRayEntries, Access::kRead},
                                                    {kBindRayGradients, Access::kRead},
                                                    {kBindTetScores, Access::kReadWrite}});
  const uint32_t push = sizeof(gpu_types::MarchPush);
  const auto pick = [atomics](std::span<const uint32_t> native,
                              std::span<const uint32_t> fallback) {
    return atomics ? native : fallback;
  };
  MarchPrograms programs;
  programs.forward = Program(device, "march_forward", kMarchForward, forward, push);
  programs.forward_counting =
      Program(device, "march_forward (counting)", kMarchForwardCounting, forward, push);
  programs.backward =
      Program(device, "march_backward", pick(kMarchBackward, kMarchBackwardCas), backward, push);
  programs.score = Program(device, "march_score", pick(kMarchScore, kMarchScoreCas), score, push);
  programs.loss = Program(device, "loss", kLoss,
                          {{kBindViews, Access::kRead},
                           {kBindBlocks, Access::kRead},
                           {kBindRayColors, Access::kRead},
                           {kBindRayGradients, Access::kWrite},
                           {kBindPartialLosses, Access::kWrite},
                           {kBindTargets, Access::kTexelRead}},
                          sizeof(gpu_types::LossPush));
  programs.adam = Program(device, "adam", kAdam,
                          {{kBindVertexGradients, Access::kReadWrite},
                           {kBindParameters, Access::kReadWrite},
                           {kBindMoments, Access::kReadWrite},
                           {kBindVertices, Access::kReadWrite}},
                          sizeof(gpu_types::AdamPush));
  return programs;
}

MarchMesh UploadMesh(const Device& device, const TetMesh& mesh,
                     std::span<const glm::vec4> parameters) {
  TETREC_CHECK(parameters.size() == mesh.positions.size(), "one parameter row a vertex");
  std::vector<glm::uvec4> tets(2 * mesh.tets.size());
  std::vector<glm::vec4> hull;
  for (size_t t = 0; t < mesh.tets.size(); ++t) {
    tets[2 * t] = mesh.tets[t];
    tets[2 * t + 1] = mesh.neighbors[t];
    for (int face = 0; face < 4; ++face) {
      if (mesh.neighbors[t][face] != kNoTet) continue;
      const auto& corner = kFaceVertices[face];
      const uint32_t a = mesh.tets[t][corner[0]], b = mesh.tets[t][corner[1]],
                     c = mesh.tets[t][corner[2]];
      const glm::dvec3 pa(mesh.positions[a]), pb(mesh.positions[b]), pc(mesh.positions[c]);
      const glm::dvec3 outward = glm::normalize(glm::cross(pb - pa, pc - pa));
      hull.emplace_back(outward, float(glm::dot(outward, pa)));
      // Wound inwards: positive in the frame of a ray that enters.
      hull.emplace_back(std::bit_cast<float>(a), std::bit_cast<float>(c), std::bit_cast<float>(b),
                        std::bit_cast<float>(uint32_t(t)));
    }
  }
  std::vector<glm::vec4> vertices(2 * mesh.positions.size());
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    vertices[2 * v] = glm::vec4(mesh.positions[v], std::exp(parameters[v].a));
    vertices[2 * v + 1] = glm::vec4(glm::vec3(parameters[v]), 0.0f);
  }
  MarchMesh result;
  result.vertex_count = uint32_t(mesh.positions.size());
  result.tet_count = uint32_t(mesh.tets.size());
  result.hull_faces = uint32_t(hull.size() / 2);
  result.tets = MakeBuffer(device, "tets", tets, VK_FORMAT_R32G32B32A32_UINT);
  result.vertices = MakeBuffer(device, "vertices", vertices, VK_FORMAT_R32G32B32A32_SFLOAT);
  result.hull = MakeBuffer(device, "hull", hull, VK_FORMAT_R32G32B32A32_SFLOAT);
  return result;
}

GpuView MakeGpuView(const RenderView& view, int grid, uint32_t first_pixel, uint32_t start_tet) {
  const Rigid3 world_from_cam = view.cam_from_world.Inverse();
  const Camera& camera = view.camera;
  GpuView result;
  result.right_in_world_fx = glm::vec4(glm::dvec4(world_from_cam.rotation[0], grid * camera.fx));
  result.down_in_world_fy = glm::vec4(glm::dvec4(world_from_cam.rotation[1], grid * camera.fy));
  result.forward_in_world_cx = glm::vec4(glm::dvec4(world_from_cam.rotation[2], grid * camera.cx));
  result.center_in_world_cy = glm::vec4(glm::dvec4(world_from_cam.translation, grid * camera.cy));
  result.size_pixel_tet = glm::uvec4(uint32_t(grid * camera.width), uint32_t(grid * camera.height),
                                     first_pixel, start_tet);
  return result;
}

}  // namespace tetrec
