// The poses of the training cameras, corrected while the field is fitted.
#pragma once

#include "core/words.h"
#include "optimize/schedule.h"
#include "render/exposure.h"
#include "render/training_renderer.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace tetrec {

enum class PoseMode {
  kAuto,  // where cameras were estimated from the photos
  kOn,
  kOff,
};
template <>
inline constexpr auto kWords<PoseMode> = std::to_array<Word<PoseMode>>({{PoseMode::kAuto, "auto"},
                                                                        {PoseMode::kOn, "on"},
                                                                        {PoseMode::kOff, "off"}});

// A camera as the run has it now.
struct CorrectedPose {
  Rigid3 cam_from_world;
  double depth = 0;  // of what it shows, in the middle [world units]; 0: not known yet, or nothing
};

// What a resumed run needs.
struct PoseState {
  std::vector<CorrectedPose> poses;  // one per training view; empty if they are not corrected
  uint32_t sweeps = 0;               // done
};

// Takes from the corrections of all cameras what they have in common: the similarity of the world
// that leaves the least sum of remaining shifts of the pictures [px]. The pictures cannot know it
// (the field could move with the cameras), but the held-out cameras would no longer fit. Cameras of
// depth 0 follow the others.
void RemoveCommonMotion(std::span<const RenderView> given, std::span<CorrectedPose> poses);

// What a sweep fits to, one of each per training view.
struct PoseTargets {
  std::span<const RenderView> given;        // the scene's own cameras
  std::span<const TargetImage> targets;     // kNotJudgedTarget: not looked at
  std::span<const ViewExposure> exposures;  // may be empty: neutral
  glm::vec3 background_srgb{0.0f};
};

// Pixels of each view that a sweep fits to: each costs 13 rays, and as many others that decide cost
// 2 rays each.
inline constexpr int kSweepPixels = 512;

// Keeps the poses of a run.
class PoseEstimate {
 public:
  PoseEstimate() = default;  // corrects nothing
  explicit PoseEstimate(std::span<const RenderView> given);
  explicit PoseEstimate(PoseState state) : state_(std::move(state)) {}

  bool is_on() const { return !state_.poses.empty(); }
  const PoseState& state() const { return state_; }
  // True if a sweep is due at this moment of the run.
  bool IsDue(const RunMoment& moment) const;
  // Fits each camera in turn to its picture with the field as it is (render/view_pose.h), and
  // removes the common motion. Returns the number of cameras that another pose fits better.
  size_t Sweep(Renderer& renderer, const PoseTargets& targets, uint64_t seed,
               int pixels = kSweepPixels);
  // No corrections, and no sweep any more.
  void GiveUp() { state_ = {}; }

 private:
  PoseState state_;
};

}  // namespace tetrec
