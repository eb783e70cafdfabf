// Projects tets onto the image, sorts them by visibility and composites them front to back.
#include "render/vulkan/projection_integrator.h"

#include "core/error.h"
#include "core/log.h"
#include "embedded_shaders.h"
#include "geometry/bounds3.h"
#include "mesh/boundary.h"
#include "render/vulkan/loop_bound.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <utility>

namespace tetrec {
namespace {

using gpu_types::ProjectionPush;
using gpu_types::ScanPush;

// A list item: tile and tet, both twice for the sort, and its share of the digit counters.
constexpr uint64_t kBytesPerItem = 20;

// The cost of walking over an item, with 8 sums for each of 4 vertices that leave.
constexpr LoopCost kItemCost{.rounds = 16, .sums = 4 * 8};

uint32_t CeilDivide(uint32_t a, uint32_t b) { return (a + b - 1) / b; }

uint32_t TileCount(const ProjectionPush& push) {
  return CeilDivide(push.block_columns, kTileColumns) * CeilDivide(push.block_rows, kTileRows);
}

// The rectangle that the blocks fill.
ProjectionPush PushOf(const RayPass& pass) {
  TETREC_CHECK(pass.rays.columns > 0,
               "projected tets need a rectangle of one view, blocks in row order");
  const RayBlock& first = pass.blocks[0];
  return {.rays = pass.push,
          .view = first.view,
          .first_x = first.x,
          .first_y = first.y,
          .block_columns = pass.rays.columns,
          .block_rows = uint32_t(pass.blocks.size()) / pass.rays.columns};
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

// Waits until the device is idle and starts recording again.
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
                                           const FieldLayout& layout)
    : device_(device),
      keys_(Keys::kCentroid),
      order_(options.order),
      fragment_memory_(options.fragment_memory),
      longest_walk_(MostItems(device, options, kItemCost)),
      prefix_sum_(device),
      sort_(device),
      zero_(device) {
  cull_ = Program(device, "projection_cull", kProjectionCull);
  compact_ = Program(device, "projection_compact", kProjectionCompact);
  centroid_keys_ = Program(device, "projection_keys (centroid)", kProjectionKeysCentroid);
  power_keys_ = Program(device, "projection_keys (power)", kProjectionKeysPower);
  gather_ = Program(device, "gather", kGather);
  count_ = Program(device, "projection_count", kProjectionCount);
  emit_ = Program(device, "projection_emit", kProjectionEmit);
  ranges_ = Program(device, "projection_ranges", kProjectionRanges);
  const auto constants = ConstantsOf(options.integral, layout);
  const SummingKernel colors{kProjectionBackward, kProjectionBackwardCas, kProjectionBackwardFixed};
  const SummingKernel positions{kProjectionBackwardPositions, kProjectionBackwardPositionsCas,
                                kProjectionBackwardPositionsFixed};
  const bool fixed_point = options.deterministic;
  forward_ = Program(device, "projection_forward", kProjectionForward, constants);
  forward_counting_ =
      Program(device, "projection_forward (counting)", kProjectionForwardCounting, constants);
  backward_ = Program(device, "projection_backward", colors.For(device, fixed_point), constants);
  backward_positions_ = Program(device, "projection_backward (positions)",
                                positions.For(device, fixed_point), constants);
  ray_states_ = Buffer(device, "ray states", kRayStateBytesWithPositions);
}

// A tet takes its rectangle (8 bytes), place, rank, high key and offset (4 each), keys and items
// twice (16), its share of digit counters and prefix sums (under 8), and its sphere on the device
// (32) and on the host (32 + 4 faces of 12).
uint64_t ProjectionIntegrator::BytesFor(const TetMesh& mesh) const {
  const uint64_t spheres = order_ == VisibilityOrder::kExact ? 112 : 0;
  return mesh.tets.size() * (8 + 4 * 4 + 16 + 8 + spheres);
}

void ProjectionIntegrator::CheckMesh(const TetMesh& mesh) const {
  if (order_ != VisibilityOrder::kExact) return;
  const std::string why = WhyNotConvex(mesh, BoundaryFaces(mesh));
  if (why.empty()) return;
  throw DataError(
      fmt::format("{}: no exact order of its tets is known across gaps; use the renderer 'march' "
                  "or 'ppll', or the order 'centroid', which is approximate",
                  why));
}

void ProjectionIntegrator::SetField(const DeviceField& field) {
  field_ = &field;
  has_warned_ = false;
  const Bounds3 bounds = BoundsOf(field.mesh.positions);
  center_ = bounds.Center();
  radius_ = 0.5 * bounds.Diagonal();
  rectangles_ = Buffer(device_, "tet rectangles", 8ull * field.tet_count);
  visible_ = Buffer(device_, "visible tets", 4ull * (field.tet_count + 1ull));
  ranks_ = Buffer(device_, "tet ranks", 4ull * field.tet_count);
  high_keys_ = Buffer(device_, "high keys", 4ull * field.tet_count);
  prefix_sum_.Reserve(field.tet_count + 1ull);
  FollowVertices(field);
  if (keys_ == Keys::kPower) {
    LogInfo(
        "projection: the mesh is Delaunay, so its {} tets are sorted by power; {} faces join tets "
        "on one sphere",
        field.tet_count, power_.tied_faces.size());
  } else if (keys_ == Keys::kRanks) {
    LogInfo("projection: {} inner faces are not Delaunay, so tets are sorted by what covers what",
            power_.bad_faces);
  }
}

void ProjectionIntegrator::FollowVertices(const DeviceField& field) {
  has_ranks_ = false;
  keys_ = Keys::kCentroid;
  if (order_ == VisibilityOrder::kCentroid) return;
  power_ = MeasurePowerOrder(field.mesh);
  keys_ = power_.bad_faces == 0 ? Keys::kPower : Keys::kRanks;
  if (keys_ == Keys::kPower) {
    spheres_ = MakeBuffer(device_, "circumspheres", SplitIntoPairs(power_.spheres),
                          VK_FORMAT_R32G32B32A32_SFLOAT);
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
  // A hundredth less than the distance to the mesh: rays are not cut there.
  push_.rounding = float(1e-5 * radius_);
  push_.start = float(0.99 * std::max(0.0, glm::distance(eye, center_) - radius_));
  SortVisible(recorder, pass);
  ForEachStretch(recorder, [&](const Push& push) { RecordForward(recorder, pass, push); });
}

void ProjectionIntegrator::Backward(CommandRecorder& recorder, const RayPass& pass) {
  const bool with_positions = HasPositions(pass.parts);
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
  recorder.DispatchMany(cull_,
                        {{kBindViews, pass.views},
                         {kBindTets, field_->tets},
                         {kBindVertices, field_->vertices},
                         {kBindRectangles, rectangles_},
                         {kBindVisible, visible_}},
                        push, field_->tet_count + 1ull);
  prefix_sum_.Record(recorder, visible_, field_->tet_count + 1u);
  Flush(recorder);
  visible_count_ = ReadWord(visible_, field_->tet_count);
  sorted_.Reserve(device_, visible_count_);
  sort_.Reserve(visible_count_);
  Grow(device_, offsets_, "item offsets", 4ull * (visible_count_ + 1ull));
  Grow(device_, tile_ranges_, "tile ranges", 8ull * TileCount(push));
  if (visible_count_ == 0) return;
  recorder.DispatchMany(compact_, {{kBindVisible, visible_}, {kBindItems, sorted_.items}}, push,
                        field_->tet_count);
  push.count = visible_count_;
  RecordKeys(recorder, pass, push);
}

// The device is idle.
void ProjectionIntegrator::RecordKeys(CommandRecorder& recorder, const RayPass& pass,
                                      const Push& push) {
  if (keys_ == Keys::kCentroid) {
    recorder.DispatchMany(centroid_keys_,
                          {{kBindItems, sorted_.items},
                           {kBindKeys, sorted_.keys},
                           {kBindViews, pass.views},
                           {kBindTets, field_->tets},
                           {kBindVertices, field_->vertices}},
                          push, push.count);
    sort_.Record(recorder, sorted_, push.count, 32);
    return;
  }
  // The last sort has precedence: ties within powers, and these within their higher words.
  UploadRanks(glm::vec3(pass.view.center_in_world_cy));
  RecordSortBy(recorder, ranks_, push.count, rank_bits_);
  if (keys_ == Keys::kRanks) return;
  recorder.DispatchMany(power_keys_,
                        {{kBindItems, sorted_.items},
                         {kBindKeys, sorted_.keys},
                         {kBindSpheres, spheres_},
                         {kBindHighKeys, high_keys_}},
                        push, push.count);
  sort_.Record(recorder, sorted_, push.count, 32);
  RecordSortBy(recorder, high_keys_, push.count, 32);
}

void ProjectionIntegrator::RecordSortBy(CommandRecorder& recorder, const Buffer& keys_of_tets,
                                        uint32_t count, int bits) {
  if (bits == 0) return;
  recorder.DispatchMany(
      gather_, {{kBindTable, keys_of_tets}, {kBindItems, sorted_.items}, {kBindKeys, sorted_.keys}},
      ScanPush{.count = count}, count);
  sort_.Record(recorder, sorted_, count, bits);
}

// Uploads the ranks of all tets, or of those that tie. The device is idle.
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
        "order is approximate (reported once per mesh)",
        tets_in_cycles, field_->tet_count);
    has_warned_ = true;
  }
}

void ProjectionIntegrator::ForEachStretch(CommandRecorder& recorder, const Composite& composite) {
  const uint32_t tiles = TileCount(push_);
  const uint64_t most = device_.properties.limits.maxStorageBufferRange / sizeof(uint32_t);
  const uint32_t capacity =
      uint32_t(std::max<uint64_t>(tiles, std::min(most, fragment_memory_ / kBytesPerItem)));
  // This many tets at a time cannot make more items than fit into 32 bits.
  const uint32_t slice = std::numeric_limits<uint32_t>::max() / tiles;
  uint32_t stretches = 0, done = 0, longest_list = 0;
  Push push = push_;
  do {
    push.offsets_first = push.first = done;
    push.count = std::min(slice, visible_count_ - done);
    done += push.count;
    recorder.DispatchMany(
        count_,
        {{kBindItems, sorted_.items}, {kBindRectangles, rectangles_}, {kBindOffsets, offsets_}},
        push, push.count + 1ull);
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
      // A list contains a tet once.
      longest_list = push.count <= longest_walk_ ? push.count : MeasureLongestList(recorder, push);
      WalkLists(push, longest_list, composite);
      ++stretches;
    }
  } while (done < visible_count_);
  lists_are_whole_ = stretches == 1;
  whole_ = push;
  whole_longest_list_ = longest_list;
}

// Walks the lists in windows of as many items as the device can walk at a time.
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

// Returns at least one. The device is idle.
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
  recorder.DispatchMany(emit_,
                        {{kBindItems, sorted_.items},
                         {kBindRectangles, rectangles_},
                         {kBindOffsets, offsets_},
                         {kBindSortedKeys, items_.keys},
                         {kBindSortedItems, items_.items}},
                        push, push.count);
  sort_.Record(recorder, items_, items, int(std::bit_width(tiles - 1)));
  push.count = items;
  recorder.Dispatch(ranges_, {{kBindKeys, items_.keys}, {kBindTileRanges, tile_ranges_}}, push,
                    CeilDivide(items, kItemRun));
}

void ProjectionIntegrator::RecordForward(CommandRecorder& recorder, const RayPass& pass,
                                         const Push& push) {
  BoundBuffers buffers = MeshAnd(pass, {{kBindItems, items_.items},
                                        {kBindTileRanges, tile_ranges_},
                                        {kBindRayColors, pass.rays.colors}});
  if (pass.count_steps) {
    buffers.emplace_back(kBindRayEntries, pass.rays.entries);
    buffers.emplace_back(kBindCounters, pass.counters);
  }
  recorder.Dispatch(pass.count_steps ? forward_counting_ : forward_, buffers, push,
                    uint64_t(TileCount(push)) * kTileRays);
}

void ProjectionIntegrator::RecordBackward(CommandRecorder& recorder, const RayPass& pass,
                                          Push push) {
  push.rays = pass.push;  // Forward may have had no fixed-point quanta
  const bool with_positions = HasPositions(pass.parts);
  BoundBuffers buffers = MeshAnd(pass, {{kBindItems, items_.items},
                                        {kBindTileRanges, tile_ranges_},
                                        {kBindRayColors, pass.rays.colors},
                                        {kBindRayGradients, pass.rays.gradients},
                                        {kBindRayStates, ray_states_},
                                        {kBindCounters, pass.counters},
                                        {kBindVertexGradients, *pass.gradients}});
  if (with_positions) {
    buffers.emplace_back(kBindPositionGradients, pass.field.position_gradients);
  }
  recorder.Dispatch(with_positions ? backward_positions_ : backward_, buffers, push,
                    uint64_t(TileCount(push)) * kTileRays);
}

}  // namespace tetrec
