// Per-pixel lists: rasterises the faces of the mesh, sorts every ray's hits, resolves them.
#include "render/vulkan/ppll_integrator.h"

#include "core/error.h"
#include "embedded_shaders.h"
#include "gpu/raster_program.h"
#include "render/vulkan/loop_bound.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

namespace tetrec {
namespace {

using gpu_types::PpllPush;

constexpr uint64_t kFragmentBytes = 8, kAppendedBytes = 16;
// Longer lists are sorted by heap: its n log n overtakes shell sort there.
constexpr uint32_t kLongestShellSort = 1024;

// Per fragment. Sorting stays below this up to the lengths that llvmpipe can sort; walking back
// takes up to 10 rounds, and one round and 8 sums for each of 3 vertices that leave.
constexpr uint32_t kSortRounds = 30;
constexpr LoopCost kSegmentCost{.rounds = 10 + 3, .sums = 3 * 8};

uint32_t LongestList(const Device& device, const RendererOptions& options) {
  return std::min(MostLoopRounds(device) / kSortRounds, MostItems(device, options, kSegmentCost));
}

// Every face once, as its place in the tet with the lower index.
std::vector<uint32_t> UniqueFaces(const TetMesh& mesh) {
  std::vector<uint32_t> faces;
  faces.reserve(2 * mesh.tets.size());
  for (uint32_t t = 0; t < mesh.tets.size(); ++t) {
    for (uint32_t i = 0; i < 4; ++i) {
      if (t < mesh.neighbors[t][i]) faces.push_back(t << 3 | i << 1);
    }
  }
  return faces;
}

// Balls around the chunks of faces.
std::vector<FaceChunk> BoundFaces(const TetMesh& mesh, std::span<const uint32_t> faces) {
  std::vector<FaceChunk> chunks;
  for (size_t first = 0; first < faces.size(); first += kFacesPerChunk) {
    const auto part = faces.subspan(first, std::min<size_t>(kFacesPerChunk, faces.size() - first));
    const auto for_each_corner = [&](const auto& body) {
      for (const uint32_t face : part) {
        for (int i = 0; i < 4; ++i) {
          const uint32_t vertex = mesh.tets[face >> 3][i];
          if (i != int(face >> 1 & 3)) body(glm::dvec3(mesh.positions[vertex]));
        }
      }
    };
    glm::dvec3 low(std::numeric_limits<double>::max()), high = -low;
    for_each_corner([&](const glm::dvec3& p) { low = glm::min(low, p), high = glm::max(high, p); });
    FaceChunk chunk{0.5 * (low + high), 0.0};
    for_each_corner([&](const glm::dvec3& p) {
      chunk.radius = std::max(chunk.radius, glm::distance(chunk.center, p));
    });
    chunks.push_back(chunk);
  }
  return chunks;
}

// Appends the chunks that rays through a tile may pass, front to back.
void AppendVisible(const RayPass& pass, const FragmentTile& tile, std::span<const FaceChunk> chunks,
                   std::vector<uint32_t>& visible) {
  const gpu_types::GpuView& view = pass.view;
  const glm::dvec3 eye(view.center_in_world_cy), right(view.right_in_world_fx),
      down(view.down_in_world_fy), forward(view.forward_in_world_cx);
  const glm::dvec2 focal(view.right_in_world_fx.w, view.down_in_world_fy.w);
  const glm::dvec2 center(view.forward_in_world_cx.w, view.center_in_world_cy.w);
  // Half a pixel wider than the tile's outer rays need.
  const glm::dvec2 first(pass.blocks[0].x + tile.x, pass.blocks[0].y + tile.y);
  const double margin = 0.5 * double(pass.push.jitter_px);
  const glm::dvec2 low = (first - margin - center) / focal;
  const glm::dvec2 high = (first + glm::dvec2(tile.width, tile.height) + margin - center) / focal;
  const glm::dvec2 low_length = glm::sqrt(1.0 + low * low),
                   high_length = glm::sqrt(1.0 + high * high);
  const glm::vec4 ball = pass.field.ball;
  const double rounding =
      1e-5 * (glm::length(eye) + glm::length(glm::dvec3(ball)) + double(ball.w));
  std::vector<std::pair<double, uint32_t>> found;
  for (uint32_t i = 0; i < chunks.size(); ++i) {
    const glm::dvec3 r = chunks[i].center - eye;
    const glm::dvec2 across(glm::dot(r, right), glm::dot(r, down));
    const double z = glm::dot(r, forward), radius = chunks[i].radius + rounding;
    const glm::dvec2 left_of = low * z - across - radius * low_length;
    const glm::dvec2 right_of = across - high * z - radius * high_length;
    if (z > -radius && std::max({left_of.x, left_of.y, right_of.x, right_of.y}) < 0.0) {
      found.emplace_back(glm::length(r), i);
    }
  }
  std::sort(found.begin(), found.end());
  for (const auto& [distance, i] : found) visible.push_back(i);
}

}  // namespace

PpllIntegrator::PpllIntegrator(const Device& device, const RendererOptions& options,
                               const FieldLayout& layout)
    : device_(device),
      fragment_memory_(options.fragment_memory),
      fragment_capacity_(std::min<uint64_t>(options.fragment_memory,
                                            device.properties.limits.maxStorageBufferRange) /
                         kFragmentBytes),
      longest_list_(LongestList(device, options)),
      sort_(options.fragment_sort) {
  faces_program_ = MakeRasterProgram(device, "ppll_faces", kPpllFacesVertex, kPpllFacesFragment);
  gather_ = Program(device, "ppll_gather", kPpllGather);
  sort_shell_ = Program(device, "ppll_sort (shell)", kPpllSortShell);
  sort_heap_ = Program(device, "ppll_sort (heap)", kPpllSortHeap);
  const auto constants = ConstantsOf(options.integral, layout);
  const SummingKernel colors{kPpllBackward, kPpllBackwardCas, kPpllBackwardFixed};
  const SummingKernel positions{kPpllBackwardPositions, kPpllBackwardPositionsCas,
                                kPpllBackwardPositionsFixed};
  const bool fixed_point = options.deterministic;
  forward_ = Program(device, "ppll_forward", kPpllForward, constants);
  forward_counting_ = Program(device, "ppll_forward (counting)", kPpllForwardCounting, constants);
  backward_ = Program(device, "ppll_backward", colors.For(device, fixed_point), constants);
  backward_positions_ =
      Program(device, "ppll_backward (positions)", positions.For(device, fixed_point), constants);
  fragments_ = Buffer(device, "fragments", kFragmentBytes);
  appended_ = Buffer(device, "appended fragments", kAppendedBytes);
}

// A tet has at most 4 faces of 4 bytes each, and its share of their chunks.
uint64_t PpllIntegrator::BytesFor(const TetMesh& mesh) const { return mesh.tets.size() * 17; }

void PpllIntegrator::SetField(const DeviceField& field) {
  TETREC_CHECK(field.tet_count < 1u << 28,
               "the vertices of all faces (3 each, 2 to 4 faces per tet) are counted in 32 bits");
  const std::vector<uint32_t> faces = UniqueFaces(field.mesh);
  face_count_ = uint32_t(faces.size());
  faces_ = MakeBuffer(device_, "faces", faces);
  face_chunks_ = BoundFaces(field.mesh, faces);
  tiles_.clear();
}

PpllPush PpllIntegrator::PushOf(const RayPass& pass, const FragmentTile& tile) const {
  return {.rays = pass.push,
          .block_columns = pass.rays.columns,
          .view = pass.blocks[0].view,
          .face_count = face_count_,
          .mesh_ball = pass.field.ball,
          .tile_x = tile.x,
          .tile_y = tile.y,
          .tile_width = tile.width,
          .tile_pixels = tile.width * tile.height};
}

// Finds the chunks that each tile may see; the device is idle.
void PpllIntegrator::CullFaces(const RayPass& pass, std::span<const FragmentTile> tiles) {
  std::vector<uint32_t> visible;
  first_visible_ = {0};
  for (const FragmentTile& tile : tiles) {
    AppendVisible(pass, tile, face_chunks_, visible);
    first_visible_.push_back(visible.size());
  }
  TETREC_CHECK(visible.size() <= UINT32_MAX, "visible chunks of faces are numbered in 32 bits");
  Grow(device_, visible_chunks_, "visible chunks", visible.size() * 4);
  visible_chunks_.Upload(visible);
}

// `i` is the tile's index in the last CullFaces.
void PpllIntegrator::DrawFaces(CommandRecorder& recorder, const RayPass& pass,
                               const FragmentTile& tile, size_t i, bool appends) {
  PpllPush push = PushOf(pass, tile);
  push.appends = appends;
  push.most_appended = uint32_t(appended_.bytes() / kAppendedBytes);
  push.first_chunk = uint32_t(first_visible_[i]);
  const uint64_t chunks = first_visible_[i + 1] - first_visible_[i];
  const uint32_t width = pass.rays.columns * kBlockWidth;
  // Pixels of the batch that are inside the image.
  const uint32_t columns =
      pass.view.size_pixel_tet.x - std::min(pass.view.size_pixel_tet.x, pass.blocks[0].x);
  const uint32_t rows =
      pass.view.size_pixel_tet.y - std::min(pass.view.size_pixel_tet.y, pass.blocks[0].y);
  recorder.FillZero(list_fills_);
  recorder.Draw(faces_program_,
                MeshAnd(pass, {{kBindFaces, faces_},
                               {kBindFaceChunks, visible_chunks_},
                               {kBindLists, lists_},
                               {kBindListFills, list_fills_},
                               {kBindFragments, fragments_},
                               {kBindAppended, appended_},
                               {kBindCounters, pass.counters}}),
                push, uint32_t(3 * kFacesPerChunk * chunks),
                {.width = width, .height = pass.rays.count / width},
                {tile.x, tile.y, std::min(tile.width, tile.x < columns ? columns - tile.x : 0),
                 std::min(tile.height, tile.y < rows ? rows - tile.y : 0)});
}

// Draws the whole batch to count its fragments, and waits.
std::vector<uint32_t> PpllIntegrator::CountFragments(CommandRecorder& recorder,
                                                     const RayPass& pass) {
  const uint32_t rays = pass.rays.count, width = pass.rays.columns * kBlockWidth;
  recorder.EndAndSubmit();  // earlier batches may still use what changes here
  recorder.Wait();
  Grow(device_, lists_, "lists", uint64_t(rays) * 8);
  Grow(device_, list_fills_, "list fills", uint64_t(rays + 1) * 4);
  const FragmentTile whole{.width = width, .height = rays / width};
  CullFaces(pass, std::span(&whole, 1));
  recorder.Begin();
  DrawFaces(recorder, pass, whole, 0, true);
  recorder.EndAndSubmit();
  recorder.Wait();
  return list_fills_.DownloadAs<uint32_t>(rays + 1);
}

// Finds the batch's fragments and cuts it into tiles. Earlier work is done when this returns.
void PpllIntegrator::PlanTiles(CommandRecorder& recorder, const RayPass& pass) {
  const uint32_t rays = pass.rays.count;
  const uint32_t width = pass.rays.columns * kBlockWidth, height = rays / width;
  const std::vector<uint32_t> counts = CountFragments(recorder, pass);
  const auto ray_at = [&](uint32_t x, uint32_t y) {
    const uint32_t block = y / kBlockHeight * pass.rays.columns + x / kBlockWidth;
    return block * kBlockRays + y % kBlockHeight * kBlockWidth + x % kBlockWidth;
  };
  tiles_ = CutIntoTiles(width, height, fragment_capacity_,
                        [&](uint32_t x, uint32_t y) { return counts[ray_at(x, y)]; });
  uint64_t most = 0, all = 0;
  std::vector<glm::uvec2> lists(rays);
  for (const FragmentTile& tile : tiles_) {
    most = std::max(most, tile.fragments);
    all += tile.fragments;
    uint32_t first = 0;
    for (uint32_t y = tile.y; y < tile.y + tile.height; ++y) {
      for (uint32_t x = tile.x; x < tile.x + tile.width; ++x) {
        const uint32_t ray = ray_at(x, y);
        lists[ray] = {first, counts[ray]};
        first += counts[ray];
      }
    }
  }
  if (most > fragment_capacity_) {
    throw EnvironmentError(
        fmt::format("one ray passes {} faces, which need {} bytes; the fragment memory and device "
                    "'{}' allow {}: raise the fragment memory, use fewer tets or the renderer "
                    "'march'",
                    most, most * kFragmentBytes, device_.properties.deviceName,
                    fragment_capacity_ * kFragmentBytes));
  }
  uint32_t longest = 0;
  for (const FragmentTile& tile : tiles_) longest = std::max(longest, tile.longest_list);
  if (longest > longest_list_) {
    throw EnvironmentError(fmt::format(
        "one ray passes {} faces; device '{}' runs no loop for more than {}: use fewer tets or "
        "the renderer 'march'",
        longest, device_.properties.deviceName, longest_list_));
  }
  lists_.Upload(lists);
  Keep(pass, all, most);
  recorder.Begin();
}

// Makes room for the fragments of the largest tile and, if the memory suffices, for those of the
// next batch, so that it needs to be drawn only once.
void PpllIntegrator::Keep(const RayPass& pass, uint64_t all, uint64_t most) {
  appended_count_ = 0;
  const uint64_t room =
      std::min(fragment_memory_ / (kAppendedBytes + kFragmentBytes),
               uint64_t(device_.properties.limits.maxStorageBufferRange) / kAppendedBytes);
  if (tiles_.size() == 1 && all * kAppendedBytes <= appended_.bytes()) {
    appended_count_ = all;
  } else {
    CullFaces(pass, tiles_);
    appended_ = {};
    const uint64_t wanted = all <= room ? std::min(room, all + all / 4) : 1;
    appended_ =
        Buffer(device_, "appended fragments", std::max<uint64_t>(wanted, 1) * kAppendedBytes);
  }
  Grow(device_, fragments_, "fragments", most * kFragmentBytes);
}

void PpllIntegrator::Sort(CommandRecorder& recorder, const RayPass& pass,
                          const FragmentTile& tile) {
  const BoundBuffers buffers = {{kBindLists, lists_}, {kBindFragments, fragments_}};
  PpllPush push = PushOf(pass, tile);
  push.longest = sort_ == FragmentSort::kAuto    ? kLongestShellSort
                 : sort_ == FragmentSort::kShell ? UINT32_MAX
                                                 : 0;
  if (push.longest > 0) {
    recorder.Dispatch(sort_shell_, buffers, push, push.tile_pixels);
  }
  if (tile.longest_list > push.longest) {
    push.shortest = std::exchange(push.longest, UINT32_MAX) + 1;
    recorder.Dispatch(sort_heap_, buffers, push, push.tile_pixels);
  }
}

void PpllIntegrator::LoadTile(CommandRecorder& recorder, const RayPass& pass, size_t i) {
  const FragmentTile& tile = tiles_[i];
  if (appended_count_ > 0) {
    PpllPush push = PushOf(pass, tile);
    push.most_appended = uint32_t(appended_count_);
    recorder.DispatchMany(
        gather_, {{kBindLists, lists_}, {kBindAppended, appended_}, {kBindFragments, fragments_}},
        push, appended_count_);
  } else {
    DrawFaces(recorder, pass, tile, i, false);
  }
  Sort(recorder, pass, tile);
}

void PpllIntegrator::Forward(CommandRecorder& recorder, const RayPass& pass) {
  TETREC_CHECK(pass.rays.columns > 0, "lists of fragments need a rectangle of rays");
  const uint32_t width = pass.rays.columns * kBlockWidth, height = pass.rays.count / width;
  const VkPhysicalDeviceLimits& limits = device_.properties.limits;
  if (width > limits.maxFramebufferWidth || height > limits.maxFramebufferHeight) {
    throw EnvironmentError(
        fmt::format("device '{}' rasterises at most {} x {} pixels, not {} x {}: use smaller "
                    "images, fewer samples per pixel or the renderer 'march'",
                    device_.properties.deviceName, limits.maxFramebufferWidth,
                    limits.maxFramebufferHeight, width, height));
  }
  PlanTiles(recorder, pass);
  for (size_t i = 0; i < tiles_.size(); ++i) {
    const FragmentTile& tile = tiles_[i];
    LoadTile(recorder, pass, i);
    recorder.Dispatch(pass.count_steps ? forward_counting_ : forward_,
                      MeshAnd(pass, {{kBindLists, lists_},
                                     {kBindListFills, list_fills_},
                                     {kBindFragments, fragments_},
                                     {kBindRayColors, pass.rays.colors},
                                     {kBindRayEntries, pass.rays.entries},
                                     {kBindCounters, pass.counters}}),
                      PushOf(pass, tile), tile.width * tile.height);
  }
}

// The tile that Forward loaded last comes first and does not have to be loaded again.
void PpllIntegrator::Backward(CommandRecorder& recorder, const RayPass& pass) {
  const bool with_positions = HasPositions(pass.parts);
  BoundBuffers buffers = MeshAnd(pass, {{kBindLists, lists_},
                                        {kBindFragments, fragments_},
                                        {kBindRayColors, pass.rays.colors},
                                        {kBindRayEntries, pass.rays.entries},
                                        {kBindRayGradients, pass.rays.gradients},
                                        {kBindCounters, pass.counters},
                                        {kBindVertexGradients, *pass.gradients}});
  if (with_positions) {
    buffers.emplace_back(kBindPositionGradients, pass.field.position_gradients);
  }
  for (size_t i = tiles_.size(); i-- > 0;) {
    const FragmentTile& tile = tiles_[i];
    if (i + 1 < tiles_.size()) LoadTile(recorder, pass, i);
    recorder.Dispatch(with_positions ? backward_positions_ : backward_, buffers, PushOf(pass, tile),
                      tile.width * tile.height);
  }
}

}  // namespace tetrec
