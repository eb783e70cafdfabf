// The motion of the mesh's vertices along the gradients of the loss.
//
// Gradients by positions are summed over some steps, then all vertices move at once, each along its
// own mean gradient (Adam with one second moment per vertex, so that the direction stays that of
// the gradient) by a share of the length of its edges, as far as no tet suffers
// (mesh/safe_motion.h). With MoveChoice::kArticle they move as in the DiffTetVR article instead
// (article_motion.h). Vertices of the boundary and in the space of the cameras stay.
#pragma once

#include "field/field_state.h"
#include "mesh/safe_motion.h"
#include "optimize/fitted_field.h"
#include "optimize/optimize_options.h"
#include "render/training_renderer.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace tetrec {

// What a resumed run needs. Arrays are (V), or empty before the first motion of a mesh.
struct MotionState {
  uint64_t motions = 0;                  // that the moments have seen
  std::vector<glm::vec3> first_moment;   // of dL/dposition
  std::vector<glm::vec3> second_moment;  // of the squares of its coordinates
  std::vector<float> size;               // mean length of a vertex's edges, and
  std::vector<float> room;               // how far it may still move [world units], both since its
                                         // tets were made (FittedField::RoomOfVertices)
  MotionCounts counts;                   // of the whole run
};

// `progress` is that of the run, in [0, 1].
class VertexMotion {
 public:
  // `views`: training pictures, whose number is the length of the article's epochs.
  VertexMotion(const OptimizeOptions& options, FittedField& field, TrainingRenderer& renderer,
               size_t views)
      : options_(options), field_(field), renderer_(renderer), views_(views) {}

  // Starts the motion if the options ask for it and the run has grown enough (schedule.h). Safe
  // motion ends at the progress kLastMotion.
  void StartIfDue(double growth);
  bool has_started() const { return has_started_; }

  // What step `step`, counted from 1, computes.
  GradientParts PartsOf(uint64_t step, double progress) const;
  // After `steps` steps: moves the vertices if it is time. `rate_share`: of the learning rates.
  void AfterStep(uint64_t steps, double progress, double rate_share);
  // From one motion to the next.
  uint64_t StepsOfMotion() const;
  // As few steps after step `step` as end with a motion, but not fewer than `fewest`.
  uint64_t StepsToAMotion(uint64_t step, uint64_t fewest) const;
  // The number of steps whose learning rates a motion after `steps` steps has: of those summed so
  // far, so that vertices get equally far however rare motions are.
  uint64_t StepsForRates(uint64_t steps) const;
  // Drops the gradients that wait for a motion, because steps without motion change the field.
  void DropSums() { renderer_.TakePositionGradients(); }
  // True if no gradients are waiting for their motion after `steps` steps: only then is the state
  // all that a resumed run needs.
  bool CanResumeAfter(uint64_t steps, double progress) const;

  // The field has got a new mesh, whose vertices come from those of the old one.
  void Follow(const Prolongation& of_vertices);

  // The state for the mesh that the field has now.
  MotionState state() const;
  // The field's mesh is that of the state.
  void Resume(MotionState state);

  const MotionCounts& counts() const { return state_.counts; }
  double seconds() const { return seconds_; }  // of this process

 private:
  bool IsArticle() const { return options_.move == MoveChoice::kArticle; }
  // The number of steps before each motion whose gradients are summed for it.
  uint64_t SummedSteps() const;
  bool IsOn(uint64_t step, double progress) const;
  // Returns true if the gradients of step `step` are summed for a motion.
  bool IsSummed(uint64_t step, double progress) const;
  void Begin();
  void AddRegulariser(std::vector<glm::dvec3>& sums) const;
  // Moves the vertices, given the sums of their gradients.
  MotionCounts Move(std::span<const glm::dvec3> gradients, double rate);
  std::vector<glm::vec3> SafeMoves(std::span<const glm::dvec3> gradients, double rate);

  const OptimizeOptions& options_;
  FittedField& field_;
  TrainingRenderer& renderer_;
  size_t views_;
  bool has_started_ = false;
  MotionState state_;
  uint64_t topology_ = 0;  // FittedField::topology() of the state
  double seconds_ = 0;
};

}  // namespace tetrec
