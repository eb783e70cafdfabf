// Projects tets onto the picture, sorts them by visibility and composites them front to back
// (Shirley and Tuchman 1990, "A polygonal approximation to direct scalar volume rendering", in
// compute and with every ray cut exactly).
#pragma once

#include "gpu/program.h"
#include "render/integrator.h"
#include "render/radix_sort.h"
#include "render/visibility_order.h"

#include <functional>

namespace tetrec {

// Every batch must be a rectangle of one view, row of blocks by row.
class ProjectionIntegrator final : public Integrator {
 public:
  // Lists of (tile, tet) take at most `options.fragment_memory` bytes, but room for one tet in all
  // tiles: where they do not fit, the sorted tets are composited a stretch at a time.
  ProjectionIntegrator(const Device& device, const RendererOptions& options, FieldStorage storage);
  uint64_t BytesFor(const TetMesh& mesh) const override;
  void CheckMesh(const TetMesh& mesh) const override;
  // Throws DataError where the order is to be exact and the boundary is not convex: both exact
  // orders follow from how tets meet at faces, and nothing meets across a gap.
  void SetField(const DeviceField& field) override;
  void Forward(CommandRecorder& recorder, const RayPass& pass) override;
  void Backward(CommandRecorder& recorder, const RayPass& pass) override;

 private:
  using Push = gpu_types::ProjectionPush;
  enum class Keys { kCentroid, kPower, kRanks };
  // Of sorted tets; `items` in all tiles together.
  struct Stretch {
    uint32_t begin, end, items;
  };

  void SortVisible(CommandRecorder& recorder, const RayPass& pass);
  void RecordKeys(CommandRecorder& recorder, const RayPass& pass, const Push& push);
  void RecordSortBy(CommandRecorder& recorder, const Buffer& keys_of_tets, uint32_t count,
                    int bits);
  void UploadRanks(const glm::vec3& eye);
  using Composite = std::function<void(const Push&)>;
  // Makes the lists of one stretch of the sorted tets after another and lets `composite` walk them.
  void ForEachStretch(CommandRecorder& recorder, const Composite& composite);
  void WalkLists(const Push& push, uint32_t longest_list, const Composite& composite) const;
  uint32_t MeasureLongestList(CommandRecorder& recorder, const Push& push) const;
  std::vector<Stretch> CutIntoStretches(uint32_t tets, uint32_t capacity) const;
  void RecordLists(CommandRecorder& recorder, Push push, uint32_t items);
  void RecordForward(CommandRecorder& recorder, const RayPass& pass, const Push& push);
  void RecordBackward(CommandRecorder& recorder, const RayPass& pass, Push push);

  const Device& device_;
  Keys keys_;
  const VisibilityOrder order_;
  const uint64_t fragment_memory_;
  const uint32_t longest_walk_;  // items of a list that the device can walk at a time
  Program cull_, compact_, centroid_keys_, power_keys_, gather_;
  Program count_, emit_, ranges_;
  Program forward_, forward_counting_, backward_, backward_positions_;
  PrefixSum prefix_sum_;
  RadixSort sort_;
  ZeroFill zero_;

  // Of the field.
  const DeviceField* field_ = nullptr;
  PowerOrder power_;  // without its spheres, which are on the device
  glm::dvec3 center_{0.0};
  double radius_ = 0;  // of a ball around center_ that holds the mesh
  Buffer spheres_;     // where tets are sorted by power
  Buffer high_keys_;   // of powers
  Buffer ranks_;       // of tets that tie, or of all
  int rank_bits_ = 0;
  bool has_ranks_ = false;
  bool has_warned_ = false;  // of cycles
  glm::vec3 ranked_eye_{0.0f};
  Buffer rectangles_, visible_;

  // Of the batch.
  Push push_;
  uint32_t visible_count_ = 0;
  SortList sorted_;  // tets, front to back
  Buffer offsets_;
  SortList items_;  // (tile, tet)
  Buffer tile_ranges_;
  Buffer ray_states_;             // where the lists are not walked at once
  bool lists_are_whole_ = false;  // items_ holds the batch's only stretch
  Push whole_;
  uint32_t whole_longest_list_ = 0;
};

}  // namespace tetrec
