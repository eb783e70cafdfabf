// Projects tets onto the picture, sorts them by visibility and composites them front to back.
#include "render/projection_integrator.h"

#include "core/error.h"
#include "core/log.h"
#include "embedded_shaders.h"
#include "geometry/bounds3.h"
#include "mesh/boundary.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <utility>

namespace tetrec {
namespace {

using gpu_types::ProjectionPush;
using gpu_types::ScanPush;

// An item in a list: tile and tet, twice for the sort, and its share of the digit counters.
constexpr uint64_t kBytesPerItem = 20;

// Walking over an item takes up to 16 rounds of loops and those of the segment's parts, and for
// each of 4 vertices that leave those of 8 sums: one in fixed point, up to 9 by compare and swap.
uint32_t LongestWalk(const Device& device, const RendererOptions& options) {
  const uint32_t a_sum = options.deterministic ? 1 : device.has_float_atomics ? 0 : 9;
  return MostLoopRounds(device) / (16 + uint32_t(options.integral.splits) + 32 * a_sum);
}

uint32_t CeilDivide(uint32_t a, uint32_t b) { return (a + b - 1) / b; }

uint32_t TileCount(const ProjectionPush& push) {
  return CeilDivide(push.block_columns, kTileColumns) * CeilDivide(push.block_rows, kTileRows);
}

// The rectangle that the blocks fill.
ProjectionPush PushOf(const RayPass& pass) {
  TETREC_CHECK(pass.rays.columns > 0,
               "projected tets want a rectangle of one view, row of blocks by row");
  const RayBlock& first = pass.blocks[0];
  return {.ray_count = pass.push.ray_count,
          .view = first.view,
          .first_x = first.x,
          .first_y = first.y,
          .block_columns = pass.rays.columns,
          .block_rows = uint32_t(pass.blocks.size()) / pass.rays.columns,
          .jitter_seed = pass.push.jitter_seed,
          .jitter_px = pass.push.jitter_px,
          .stop_depth = pass.push.stop_depth,
          .first_cell = pass.field.first_cell};
}

// High and low parts of spheres, two rows each.
std::vector<glm::vec4> SplitIntoPairs(std::span<const glm::dvec4> spheres) {
  std::vector<glm::vec4> rows;
  for (const glm::dvec4& sphere : spheres) {
    const glm::vec4 high(sphere);
    rows.push_back(high);
    rows.emplace_back(sphere - glm::dvec4(high));
  }
  return rows;
}

// Until the device is idle; recording goes on.
void Flush(CommandRecorder& recorder) {
  recorder.EndAndSubmit();
  recorder.Begin();
}

uint32_t ReadWord(const Buffer& buffer, uint64_t index) {
  uint32_t word = 0;
  buffer.Download(&word, sizeof(word), index * sizeof(word));
  return word;
}

}  // namespace

ProjectionIntegrator::ProjectionIntegrator(const Device& device, const RendererOptions& options,
                                           FieldStorage storage)
    : device_(device),
      keys_(Keys::kCentroid),
      order_(options.order),
      fragment_memory_(options.fragment_memory),
      longest_walk_(LongestWalk(device, options)),
      prefix_sum_(device),
      sort_(device),
      zero_(device) {
  const auto make = [&device](const char* name, std::span<const uint32_t> spirv,
                              std::vector<BindingSpec> bindings,
                              std::span<const SpecializationConstant> constants = {}) {
    return Program(device, name, spirv, std::move(bindings), sizeof(ProjectionPush), constants);
  };
  const auto constants = ConstantsOf(options.integral, storage);
  cull_ = make("projection_cull", kProjectionCull,
               {{kBindViews, Access::kTexelRead},
                {kBindTets, Access::kTexelRead},
                {kBindVertices, Access::kTexelRead},
                {kBindRectangles, Access::kWrite},
                {kBindVisible, Access::kWrite}});
  compact_ = make("projection_compact", kProjectionCompact,
                  {{kBindVisible, Access::kRead}, {kBindItems, Access::kWrite}});
  centroid_keys_ = make("projection_keys (centroid)", kProjectionKeysCentroid,
                        {{kBindItems, Access::kRead},
                         {kBindKeys, Access::kWrite},
                         {kBindViews, Access::kTexelRead},
                         {kBindTets, Access::kTexelRead},
                         {kBindVertices, Access::kTexelRead}});
  power_keys_ = make("projection_keys (power)", kProjectionKeysPower,
                     {{kBindItems, Access::kRead},
                      {kBindKeys, Access::kWrite},
                      {kBindSpheres, Access::kTexelRead},
                      {kBindHighKeys, Access::kWrite}});
  gather_ = Program(
      device, "gather", kGather,
      {{kBindTable, Access::kRead}, {kBindItems, Access::kRead}, {kBindKeys, Access::kWrite}},
      sizeof(ScanPush));
  count_ = make("projection_count", kProjectionCount,
                {{kBindItems, Access::kRead},
                 {kBindRectangles, Access::kRead},
                 {kBindOffsets, Access::kWrite}});
  emit_ = make("projection_emit", kProjectionEmit,
               {{kBindItems, Access::kRead},
                {kBindRectangles, Access::kRead},
                {kBindOffsets, Access::kRead},
                {kBindSortedKeys, Access::kWrite},
                {kBindSortedItems, Access::kWrite}});
  ranges_ = make("projection_ranges", kProjectionRanges,
                 {{kBindKeys, Access::kRead}, {kBindTileRanges, Access::kWrite}});
  std::vector<BindingSpec> walk = {
      {kBindViews, Access::kTexelRead}, {kBindBlocks, Access::kTexelRead},
      {kBindTets, Access::kTexelRead},  {kBindVertices, Access::kTexelRead},
      {kBindItems, Access::kRead},      {kBindTileRanges, Access::kRead}};
  std::vector<BindingSpec> forward = walk, backward = walk;
  forward.push_back({kBindRayColors, Access::kReadWrite});
  forward_ = make("projection_forward", kProjectionForward, forward, constants);
  forward.insert(forward.end(),
                 {{kBindRayEntries, Access::kReadWrite}, {kBindCounters, Access::kReadWrite}});
  forward_counting_ =
      make("projection_forward (counting)", kProjectionForwardCounting, forward, constants);
  backward.insert(backward.end(), {{kBindRayColors, Access::kRead},
                                   {kBindRayGradients, Access::kRead},
                                   {kBindRayStates, Access::kReadWrite},
                                   {kBindCounters, Access::kReadWrite},
                                   {kBindVertexGradients, Access::kReadWrite}});
  const SummingKernel colors{kProjectionBackward, kProjectionBackwardCas, kProjectionBackwardFixed};
  backward_ =
      make("projection_backward", colors.For(device, options.deterministic), backward, constants);
  backward.push_back({kBindPositionGradients, Access::kReadWrite});
  const SummingKernel positions{kProjectionBackwardPositions, kProjectionBackwardPositionsCas,
                                kProjectionBackwardPositionsFixed};
  backward_positions_ = make("projection_backward (positions)",
                             positions.For(device, options.deterministic), backward, constants);
  ray_states_ = Buffer(device, "ray states", kRayStateBytesWithPositions);
}

// A tet takes its rectangle (8 bytes), place, rank, high key, offset (4 each), keys and items twice
// (16), its share of digits' counters and prefix sums (under 8), and its sphere on the device (32)
// and on the host (32 + 4 faces of 12).
uint64_t ProjectionIntegrator::BytesFor(const TetMesh& mesh) const {
  const uint64_t spheres = order_ == VisibilityOrder::kExact ? 112 : 0;
  return mesh.tets.size() * (8 + 4 * 4 + 16 + 8 + spheres);
}

void ProjectionIntegrator::CheckMesh(const TetMesh& mesh) const {
  if (order_ != VisibilityOrder::kExact) return;
  const std::string why = WhyNotConvex(mesh, BoundaryFaces(mesh));
  if (why.empty()) return;
  throw DataError(
      fmt::format("{}: no exact order of its tets is known across gaps; use --renderer march or "
                  "ppll, or --order centroid, which is approximate",
                  why));
}

void ProjectionIntegrator::SetField(const DeviceField& field) {
  field_ = &field;
  has_ranks_ = has_warned_ = false;
  const Bounds3 bounds = BoundsOf(field.mesh.positions);
  center_ = bounds.Center();
  radius_ = 0.5 * bounds.Diagonal();
  rectangles_ = Buffer(device_, "tet rectangles", 8ull * field.tet_count);
  visible_ = Buffer(device_, "visible tets", 4ull * (field.tet_count + 1ull));
  ranks_ = Buffer(device_, "tet ranks", 4ull * field.tet_count);
  high_keys_ = Buffer(device_, "high keys", 4ull * field.tet_count);
  prefix_sum_.Reserve(field.tet_count + 1ull);
  keys_ = Keys::kCentroid;
  if (order_ == VisibilityOrder::kCentroid) return;
  power_ = MeasurePowerOrder(field.mesh);
  keys_ = power_.bad_faces == 0 ? Keys::kPower : Keys::kRanks;
  if (keys_ == Keys::kPower) {
    spheres_ = MakeBuffer(device_, "circumspheres", SplitIntoPairs(power_.spheres),
                          VK_FORMAT_R32G32B32A32_SFLOAT);
    LogInfo(
        "projection: the mesh is Delaunay, its {} tets are sorted by power; {} faces join tets "
        "on one sphere",
        field.tet_count, power_.tied_faces.size());
  } else {
    LogInfo("projection: {} inner faces are not Delaunay, tets are sorted by what covers what",
            power_.bad_faces);
  }
  power_.spheres = {};
}

void ProjectionIntegrator::Forward(CommandRecorder& recorder, const RayPass& pass) {
  TETREC_CHECK(field_ == &pass.field, "projection: no field");
  push_ = PushOf(pass);
  const glm::dvec3 eye(glm::vec3(pass.view.center_in_world_cy));
  const glm::dvec3 from_origin = eye - power_.origin;
  push_.eye_high = glm::vec4(glm::vec3(from_origin), 0.0f);
  push_.eye_low = glm::vec4(glm::vec3(from_origin - glm::dvec3(glm::vec3(from_origin))), 0.0f);
  // A hundredth less than the way to the mesh: rays are not cut there.
  push_.rounding = float(1e-5 * radius_);
  push_.start = float(0.99 * std::max(0.0, glm::distance(eye, center_) - radius_));
  SortVisible(recorder, pass);
  ForEachStretch(recorder, [&](const Push& push) { RecordForward(recorder, pass, push); });
}

void ProjectionIntegrator::Backward(CommandRecorder& recorder, const RayPass& pass) {
  const bool with_positions = pass.parts == GradientParts::kColorDensityPosition;
  const uint64_t bytes =
      uint64_t(with_positions ? kRayStateBytesWithPositions : kRayStateBytes) * pass.rays.capacity;
  const bool at_once = lists_are_whole_ && whole_longest_list_ <= longest_walk_;
  if (!at_once && ray_states_.bytes() < bytes) {
    Flush(recorder);  // a batch before this one may still be using the buffer
    Grow(device_, ray_states_, "ray states", bytes);
  }
  const auto composite = [&](const Push& push) { RecordBackward(recorder, pass, push); };
  if (lists_are_whole_) {
    WalkLists(whole_, whole_longest_list_, composite);
  } else {
    ForEachStretch(recorder, composite);
  }
}

void ProjectionIntegrator::SortVisible(CommandRecorder& recorder, const RayPass& pass) {
  Push push = push_;
  push.count = field_->tet_count;
  const Buffer* culled[] = {&pass.views, &field_->tets, &field_->vertices, &rectangles_, &visible_};
  recorder.DispatchMany(cull_, culled, push, field_->tet_count + 1ull, kWorkgroupSize);
  prefix_sum_.Record(recorder, visible_, field_->tet_count + 1u);
  Flush(recorder);
  visible_count_ = ReadWord(visible_, field_->tet_count);
  sorted_.Reserve(device_, visible_count_);
  sort_.Reserve(visible_count_);
  Grow(device_, offsets_, "item offsets", 4ull * (visible_count_ + 1ull));
  Grow(device_, tile_ranges_, "tile ranges", 8ull * TileCount(push));
  if (visible_count_ == 0) return;
  const Buffer* listed[] = {&visible_, &sorted_.items};
  recorder.DispatchMany(compact_, listed, push, field_->tet_count, kWorkgroupSize);
  push.count = visible_count_;
  RecordKeys(recorder, pass, push);
}

// The device is idle.
void ProjectionIntegrator::RecordKeys(CommandRecorder& recorder, const RayPass& pass,
                                      const Push& push) {
  if (keys_ == Keys::kCentroid) {
    const Buffer* buffers[] = {&sorted_.items, &sorted_.keys, &pass.views, &field_->tets,
                               &field_->vertices};
    recorder.DispatchMany(centroid_keys_, buffers, push, push.count, kWorkgroupSize);
    sort_.Record(recorder, sorted_, push.count, 32);
    return;
  }
  // The last sort decides first: ties within powers within their higher words.
  UploadRanks(glm::vec3(pass.view.center_in_world_cy));
  RecordSortBy(recorder, ranks_, push.count, rank_bits_);
  if (keys_ == Keys::kRanks) return;
  const Buffer* buffers[] = {&sorted_.items, &sorted_.keys, &spheres_, &high_keys_};
  recorder.DispatchMany(power_keys_, buffers, push, push.count, kWorkgroupSize);
  sort_.Record(recorder, sorted_, push.count, 32);
  RecordSortBy(recorder, high_keys_, push.count, 32);
}

void ProjectionIntegrator::RecordSortBy(CommandRecorder& recorder, const Buffer& keys_of_tets,
                                        uint32_t count, int bits) {
  if (bits == 0) return;
  const Buffer* buffers[] = {&keys_of_tets, &sorted_.items, &sorted_.keys};
  recorder.DispatchMany(gather_, buffers, ScanPush{.count = count}, count, kWorkgroupSize);
  sort_.Record(recorder, sorted_, count, bits);
}

// Ranks of all tets, or of those that tie. The device is idle.
void ProjectionIntegrator::UploadRanks(const glm::vec3& eye) {
  if (has_ranks_ && eye == ranked_eye_) return;
  has_ranks_ = true;
  ranked_eye_ = eye;
  const auto [ranks, tets_in_cycles] = keys_ == Keys::kPower ? RankTies(field_->mesh, power_, eye)
                                                             : RankByVisibility(field_->mesh, eye);
  rank_bits_ =
      ranks.empty() ? 0 : int(std::bit_width(*std::max_element(ranks.begin(), ranks.end())));
  if (rank_bits_ > 0) ranks_.Upload(ranks);
  if (tets_in_cycles > 0 && !has_warned_) {
    LogWarning(
        "projection: {} of {} tets cover one another in cycles as seen from a camera; their "
        "order is approximate (told once a mesh)",
        tets_in_cycles, field_->tet_count);
    has_warned_ = true;
  }
}

void ProjectionIntegrator::ForEachStretch(CommandRecorder& recorder, const Composite& composite) {
  const uint32_t tiles = TileCount(push_);
  const uint64_t most = device_.properties.limits.maxStorageBufferRange / sizeof(uint32_t);
  const uint32_t capacity =
      uint32_t(std::max<uint64_t>(tiles, std::min(most, fragment_memory_ / kBytesPerItem)));
  // So many tets at a time cannot make more items than 32 bits count.
  const uint32_t slice = std::numeric_limits<uint32_t>::max() / tiles;
  uint32_t stretches = 0, done = 0, longest_list = 0;
  Push push = push_;
  do {
    push.offsets_first = push.first = done;
    push.count = std::min(slice, visible_count_ - done);
    done += push.count;
    const Buffer* counted[] = {&sorted_.items, &rectangles_, &offsets_};
    recorder.DispatchMany(count_, counted, push, push.count + 1ull, kWorkgroupSize);
    prefix_sum_.Record(recorder, offsets_, push.count + 1u);
    Flush(recorder);
    const std::vector<Stretch> cut = CutIntoStretches(push.count, capacity);
    for (const Stretch& stretch : cut) {
      items_.Reserve(device_, stretch.items);
      sort_.Reserve(stretch.items);
    }
    for (const Stretch& stretch : cut) {
      push.is_last = done == visible_count_ && &stretch == &cut.back();
      push.first = push.offsets_first + stretch.begin;
      push.count = stretch.end - stretch.begin;
      push.is_first = stretches == 0;
      RecordLists(recorder, push, stretch.items);
      // A list holds a tet once.
      longest_list = push.count <= longest_walk_ ? push.count : MeasureLongestList(recorder, push);
      WalkLists(push, longest_list, composite);
      ++stretches;
    }
  } while (done < visible_count_);
  lists_are_whole_ = stretches == 1;
  whole_ = push;
  whole_longest_list_ = longest_list;
}

// As many items of every list at a time as the device can walk.
void ProjectionIntegrator::WalkLists(const Push& push, uint32_t longest_list,
                                     const Composite& composite) const {
  Push window = push;
  window.first = 0;
  window.count = longest_walk_;
  bool is_last = false;
  while (!is_last) {
    is_last = longest_list - window.first <= longest_walk_;
    window.is_first = push.is_first && window.first == 0;
    window.is_last = push.is_last && is_last;
    composite(window);
    window.first += longest_walk_;
  }
}

uint32_t ProjectionIntegrator::MeasureLongestList(CommandRecorder& recorder,
                                                  const Push& push) const {
  Flush(recorder);
  uint32_t longest = 0;
  for (const glm::uvec2& range : tile_ranges_.DownloadAs<glm::uvec2>(TileCount(push))) {
    longest = std::max(longest, range.y - range.x);
  }
  return longest;
}

// One at least. The device is idle.
std::vector<ProjectionIntegrator::Stretch> ProjectionIntegrator::CutIntoStretches(
    uint32_t tets, uint32_t capacity) const {
  const uint32_t total = ReadWord(offsets_, tets);
  if (total <= capacity) return {{0, tets, total}};
  const auto offsets = offsets_.DownloadAs<uint32_t>(tets + 1ull);
  std::vector<Stretch> stretches;
  uint32_t begin = 0;
  while (begin < tets) {
    // The last tet whose items still fit; one tet always does.
    const auto past = std::upper_bound(offsets.begin() + begin, offsets.end(),
                                       uint64_t(offsets[begin]) + capacity);
    const uint32_t end = uint32_t(past - offsets.begin()) - 1;
    stretches.push_back({begin, end, offsets[end] - offsets[begin]});
    begin = end;
  }
  return stretches;
}

void ProjectionIntegrator::RecordLists(CommandRecorder& recorder, Push push, uint32_t items) {
  const uint32_t tiles = TileCount(push);
  zero_.Record(recorder, tile_ranges_, 2ull * tiles);
  if (items == 0) return;
  const Buffer* emitted[] = {&sorted_.items, &rectangles_, &offsets_, &items_.keys, &items_.items};
  recorder.DispatchMany(emit_, emitted, push, push.count, kWorkgroupSize);
  sort_.Record(recorder, items_, items, int(std::bit_width(tiles - 1)));
  push.count = items;
  const Buffer* ranged[] = {&items_.keys, &tile_ranges_};
  recorder.Dispatch(ranges_, ranged, push, CeilDivide(items, kItemRun), kWorkgroupSize);
}

void ProjectionIntegrator::RecordForward(CommandRecorder& recorder, const RayPass& pass,
                                         const Push& push) {
  std::vector<const Buffer*> buffers = {&pass.views,       &pass.rays.blocks, &field_->tets,
                                        &field_->vertices, &items_.items,     &tile_ranges_,
                                        &pass.rays.colors};
  if (pass.count_steps) buffers.insert(buffers.end(), {&pass.rays.entries, &pass.counters});
  recorder.Dispatch(pass.count_steps ? forward_counting_ : forward_, buffers, push,
                    uint64_t(TileCount(push)) * kTileRays, kWorkgroupSize);
}

void ProjectionIntegrator::RecordBackward(CommandRecorder& recorder, const RayPass& pass,
                                          Push push) {
  push.color_quanta = pass.push.color_quanta;
  push.density_quanta = pass.push.density_quanta;
  push.position_quanta = pass.push.position_quanta;
  push.largest_quanta = pass.push.largest_quanta;
  const bool with_positions = pass.parts == GradientParts::kColorDensityPosition;
  std::vector<const Buffer*> buffers = {&pass.views,       &pass.rays.blocks,    &field_->tets,
                                        &field_->vertices, &items_.items,        &tile_ranges_,
                                        &pass.rays.colors, &pass.rays.gradients, &ray_states_,
                                        &pass.counters,    &pass.field.gradients};
  if (with_positions) buffers.push_back(&pass.field.position_gradients);
  recorder.Dispatch(with_positions ? backward_positions_ : backward_, buffers, push,
                    uint64_t(TileCount(push)) * kTileRays, kWorkgroupSize);
}

}  // namespace tetrec
