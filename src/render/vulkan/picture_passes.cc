// Passes over the pixels of one view: colours, depths, gradients.
#include "render/vulkan/picture_passes.h"

#include "mesh/locate.h"
#include "render/ray_blocks.h"
#include "render/vulkan/gpu_view.h"

#include <algorithm>
#include <cmath>

namespace tetrec {

using gpu_types::GpuView;

namespace {

// The number of rays per submit. It bounds the ray buffers, the workgroups of a dispatch and the
// values of the device's 32-bit counters.
constexpr uint32_t kRaysPerSubmit = 1u << 17;

// Batches of a tile are whole rows of its blocks, so each is a tile, too.
template <class Body>
void ForEachBatch(std::span<const RayBlock> blocks, const Body& body) {
  const size_t row = std::max(1u, TileColumns(blocks));
  const size_t batch = std::max<size_t>(1, kRaysPerSubmit / kRaysPerBlock / row) * row;
  for (size_t first = 0; first < blocks.size(); first += batch) {
    body(blocks.subspan(first, std::min(batch, blocks.size() - first)));
  }
}

// The gradients of the rays of blocks of an image.
std::vector<glm::vec4> GradientsOfRays(std::span<const RayBlock> blocks, const Camera& camera,
                                       std::span<const glm::vec4> pixel_gradient) {
  std::vector<glm::vec4> gradients(blocks.size() * kRaysPerBlock, glm::vec4(0.0f));
  for (size_t r = 0; r < gradients.size(); ++r) {
    const glm::ivec2 at = PixelOfRay(blocks, r);
    if (at.x < camera.width && at.y < camera.height) {
      gradients[r] = pixel_gradient[size_t(at.y) * size_t(camera.width) + size_t(at.x)];
    }
  }
  return gradients;
}

}  // namespace

PicturePasses::PicturePasses(const Device& device, const RendererOptions& options,
                             PassCounters& counters, ViewColors& view_colors)
    : device_(device),
      options_(options),
      counters_(counters),
      view_colors_(view_colors),
      recorder_(device),
      view_(device, "view", sizeof(GpuView), VK_FORMAT_R32G32B32A32_UINT) {}

RenderedImage PicturePasses::Render(Integrator& integrator, DeviceField& field,
                                    const RenderView& view, int samples) {
  const int width = view.camera.width, height = view.camera.height;
  SetView(field, view, samples);
  RenderedImage image{width, height, std::vector<glm::vec3>(size_t(width) * height),
                      std::vector<float>(size_t(width) * height)};
  const float share = 1.0f / float(samples * samples);
  ForEachBatch(CoveringBlocks(width * samples, height * samples),
               [&](std::span<const RayBlock> blocks) {
                 const std::vector<glm::vec4> colors = MarchBatch(integrator, field, blocks);
                 for (size_t r = 0; r < colors.size(); ++r) {
                   const glm::ivec2 at = PixelOfRay(blocks, r);
                   if (at.x >= width * samples || at.y >= height * samples) continue;
                   const size_t pixel = size_t(at.y / samples) * width + at.x / samples;
                   image.color_srgb[pixel] += share * glm::vec3(colors[r]);
                   image.transmittance[pixel] += share * std::exp(-colors[r].a);
                 }
               });
  return image;
}

DepthMap PicturePasses::RenderDepth(MarchIntegrator& march, DeviceField& field,
                                    const RenderView& view, double optical_depth) {
  const int width = view.camera.width, height = view.camera.height;
  SetView(field, view, 1);
  DepthMap map = MakeDepthMap(width, height);
  ForEachBatch(CoveringBlocks(width, height), [&](std::span<const RayBlock> blocks) {
    const std::vector<float> reaches = ReachesOfBatch(march, field, blocks, optical_depth);
    for (size_t r = 0; r < reaches.size(); ++r) {
      const glm::ivec2 at = PixelOfRay(blocks, r);
      if (at.x < width && at.y < height && reaches[r] > 0) {
        map.At(at.x, at.y) = float(DepthOfDistance(view.camera, at, double(reaches[r])));
      }
    }
  });
  return map;
}

std::vector<glm::vec4> PicturePasses::MarchBlocks(Integrator& integrator, DeviceField& field,
                                                  const RenderView& view,
                                                  std::span<const RayBlock> blocks) {
  SetView(field, view, 1);
  std::vector<glm::vec4> rays;
  rays.reserve(blocks.size() * kRaysPerBlock);
  ForEachBatch(blocks, [&](std::span<const RayBlock> batch) {
    const std::vector<glm::vec4> colors = MarchBatch(integrator, field, batch);
    rays.insert(rays.end(), colors.begin(), colors.end());
  });
  return rays;
}

void PicturePasses::Backpropagate(Integrator& integrator, DeviceField& field,
                                  const RenderView& view, std::span<const glm::vec4> pixel_gradient,
                                  GradientParts parts, const FixedPoint& fixed) {
  SetView(field, view, 1);
  ForEachBatch(CoveringBlocks(view.camera.width, view.camera.height),
               [&](std::span<const RayBlock> blocks) {
                 MarchBatch(integrator, field, blocks);
                 rays_.gradients.Upload(GradientsOfRays(blocks, view.camera, pixel_gradient));
                 RayPass pass = PassOver(field, blocks, fixed);
                 pass.parts = parts;
                 Submit([&] {
                   integrator.Backward(recorder_, pass);
                   view_colors_.RecordBackward(recorder_, pass);
                 });
               });
}

void PicturePasses::SetView(const DeviceField& field, const RenderView& view, int samples) {
  const uint32_t tet =
      FindTet(field.mesh, view.cam_from_world.Inverse().translation, 0, field.not_convex.empty());
  gpu_view_ = MakeGpuView(view, samples, 0, tet);
  view_.Upload(&gpu_view_, sizeof(gpu_view_));
}

RayPass PicturePasses::PassOver(DeviceField& field, std::span<const RayBlock> blocks,
                                const FixedPoint& fixed) {
  RayPass pass = MakePass(field, rays_, view_, blocks, gpu_view_, counters_.buffer(),
                          options_.stop_transmittance, fixed);
  view_colors_.MakeRoom(field, 1);
  view_colors_.Bind(pass);
  return pass;
}

template <class Record>
void PicturePasses::Submit(const Record& record) {
  recorder_.Begin();
  record();
  recorder_.EndAndSubmit();
  recorder_.Wait();
}

// Colour and optical depth per ray of the view.
std::vector<glm::vec4> PicturePasses::MarchBatch(Integrator& integrator, DeviceField& field,
                                                 std::span<const RayBlock> blocks) {
  rays_.SetBlocks(device_, blocks, std::span(&gpu_view_, 1));
  counters_.AddRays(rays_.count);
  RayPass pass = PassOver(field, blocks, {});
  pass.count_steps = options_.count_steps;
  Submit([&] {
    view_colors_.Record(recorder_, pass);
    integrator.Forward(recorder_, pass);
  });
  counters_.Collect();
  return rays_.colors.DownloadAs<glm::vec4>(rays_.count);
}

// Distances from the camera at which rays of the view have this optical depth; 0: nowhere.
std::vector<float> PicturePasses::ReachesOfBatch(MarchIntegrator& march, DeviceField& field,
                                                 std::span<const RayBlock> blocks,
                                                 double optical_depth) {
  rays_.SetBlocks(device_, blocks, std::span(&gpu_view_, 1));
  counters_.AddRays(rays_.count);
  RayPass pass = PassOver(field, blocks, {});
  pass.push.stop_depth = float(optical_depth);
  const Buffer reaches(device_, "ray reaches", uint64_t{rays_.count} * 4);
  Submit([&] { march.ForwardWithReaches(recorder_, pass, reaches); });
  counters_.Collect();
  return reaches.DownloadAs<float>(rays_.count);
}

}  // namespace tetrec
