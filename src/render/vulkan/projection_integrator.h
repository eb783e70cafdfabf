// Projects tets onto the image, sorts them by visibility and composites them front to back
// (Shirley and Tuchman 1990, "A polygonal approximation to direct scalar volume rendering", in
// compute shaders and with every ray cut exactly).
#pragma once

#include "gpu/program.h"
#include "render/vulkan/integrator.h"
#include "render/vulkan/radix_sort.h"
#include "render/vulkan/visibility_order.h"

#include <functional>

namespace tetrec {

// Every batch must be a rectangle of one view, its blocks in row order.
class ProjectionIntegrator final : public Integrator {
 public:
  // Lists of (tile, tet) take at most `options.fragment_memory` bytes, but at least the room for
  // one tet in all tiles: if they do not fit, the sorted tets are composited one stretch at a time.
  ProjectionIntegrator(const Device& device, const RendererOptions& options,
                       const FieldLayout& layout);
  uint64_t BytesFor(const TetMesh& mesh) const override;
  void CheckMesh(const TetMesh& mesh) const override;
  // Throws DataError if the order is to be exact and the boundary is not convex: both exact orders
  // follow from how tets meet at faces, and tets do not meet across a gap.
  void SetField(const DeviceField& field) override;
  void FollowVertices(const DeviceField& field) override;
  void Forward(CommandRecorder& recorder, const RayPass& pass) override;
  void Backward(CommandRecorder& recorder, const RayPass& pass) override;

 private:
  using Push = gpu_types::ProjectionPush;
  enum class Keys { kCentroid, kPower, kRanks };
  // A range of sorted tets; `items` counts those of all tiles together.
  struct Stretch {
    uint32_t begin, end, items;
  };

  void SortVisible(CommandRecorder& recorder, const RayPass& pass);
  void RecordKeys(CommandRecorder& recorder, const RayPass& pass, const Push& push);
  void RecordSortBy(CommandRecorder& recorder, const Buffer& keys_of_tets, uint32_t count,
                    int bits);
  void UploadRanks(const glm::vec3& eye);
  using Composite = std::function<void(const Push&)>;
  // Makes the lists of one stretch of sorted tets after another and lets `composite` walk them.
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

  // For the current field.
  const DeviceField* field_ = nullptr;
  PowerOrder power_;  // without its spheres, which are on the device
  glm::dvec3 center_{0.0};
  double radius_ = 0;  // of a ball around center_ that contains the mesh
  Buffer spheres_;     // if tets are sorted by power
  Buffer high_keys_;   // of powers
  Buffer ranks_;       // of tied tets, or of all
  int rank_bits_ = 0;
  bool has_ranks_ = false;
  bool has_warned_ = false;  // of cycles
  glm::vec3 ranked_eye_{0.0f};
  Buffer rectangles_, visible_;

  // For the current batch.
  Push push_;
  uint32_t visible_count_ = 0;
  SortList sorted_;  // tets, front to back
  Buffer offsets_;
  SortList items_;  // (tile, tet)
  Buffer tile_ranges_;
  Buffer ray_states_;             // if the lists are not walked at once
  bool lists_are_whole_ = false;  // items_ contains the batch's only stretch
  Push whole_;
  uint32_t whole_longest_list_ = 0;
};

}  // namespace tetrec
