// The motion of the mesh's vertices along the gradients of the loss.
#include "optimize/vertex_motion.h"

#include "core/timer.h"
#include "mesh/mesh_edges.h"
#include "optimize/article_motion.h"

#include <glm/common.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

namespace tetrec {
namespace {

// The gradients of a coarse first field move vertices nowhere useful.
constexpr double kFirstMotion = 0.05;
// At the end of a run, while the noise of batches settles, the mesh stands still.
constexpr double kLastMotion = 0.8;
constexpr float kBeta1 = 0.9f, kBeta2 = 0.95f;

std::vector<float> SizesOfVertices(const TetMesh& mesh) {
  const std::vector<double> mean_edges = MeanEdgesOfVertices(mesh);
  return {mean_edges.begin(), mean_edges.end()};
}

}  // namespace

void VertexMotion::StartIfDue(double growth) {
  if (IsArticle() || (options_.move == MoveChoice::kSafe && growth >= kFirstMotion)) {
    has_started_ = true;
  }
}

bool VertexMotion::IsOn(uint64_t step, double progress) const {
  return has_started_ && (IsArticle() ? IsInJointEpoch(step, views_) : progress < kLastMotion);
}

uint64_t VertexMotion::StepsOfMotion() const {
  return IsArticle() ? 1 : renderer_.Pace().steps_per_motion;
}

uint64_t VertexMotion::StepsToAMotion(uint64_t step, uint64_t fewest) const {
  const uint64_t period = StepsOfMotion();
  return (step + fewest + period - 1) / period * period - step;
}

uint64_t VertexMotion::SummedSteps() const { return std::min(StepsOfMotion(), kMostSummedBatches); }

bool VertexMotion::IsSummed(uint64_t step, double progress) const {
  const uint64_t of_motion = (step - 1) % StepsOfMotion();
  return IsOn(step, progress) && of_motion >= StepsOfMotion() - SummedSteps();
}

uint64_t VertexMotion::StepsForRates(uint64_t steps) const {
  return steps * SummedSteps() / StepsOfMotion();
}

GradientParts VertexMotion::PartsOf(uint64_t step, double progress) const {
  return IsSummed(step, progress) ? GradientParts::kMotion : GradientParts::kColorDensity;
}

bool VertexMotion::CanResumeAfter(uint64_t steps, double progress) const {
  return steps == 0 || !IsSummed(steps, progress) || steps % StepsOfMotion() == 0;
}

void VertexMotion::AfterStep(uint64_t steps, double progress, double rate_share) {
  if (!IsOn(steps, progress) || steps % StepsOfMotion() != 0) return;
  const Timer timer;
  GradientSums sums = renderer_.TakePositionGradients();
  if (sums.position.empty()) return;  // the field was put anew since
  if (options_.quality.strength > 0) AddRegulariser(sums.position);
  if (state_.size.empty() || topology_ != field_.topology()) Begin();
  state_.counts.Add(Move(sums.position, PositionRateOf(options_) * rate_share));
  seconds_ += timer.seconds();
}

// The regulariser is a part of the loss of each step.
void VertexMotion::AddRegulariser(std::vector<glm::dvec3>& sums) const {
  const std::vector<glm::dvec3> of_step = RegulariserGradients(field_.mesh(), options_.quality);
  for (size_t v = 0; v < sums.size(); ++v) sums[v] += double(SummedSteps()) * of_step[v];
}

void VertexMotion::Begin() {
  const TetMesh& mesh = field_.mesh();
  const size_t count = mesh.positions.size();
  Resume({0, std::vector<glm::vec3>(count, glm::vec3(0.0f)),
          std::vector<glm::vec3>(count, glm::vec3(0.0f)), SizesOfVertices(mesh),
          field_.RoomOfVertices(), state_.counts});
}

void VertexMotion::Follow(const Prolongation& of_vertices) {
  if (state_.size.empty()) return;
  Resume({.motions = state_.motions,
          .first_moment = Prolong(std::move(state_.first_moment), of_vertices),
          .second_moment = Prolong(std::move(state_.second_moment), of_vertices),
          .size = SizesOfVertices(field_.mesh()),
          .room = field_.RoomOfVertices(),
          .counts = state_.counts});
}

MotionState VertexMotion::state() const {
  return topology_ == field_.topology() ? state_ : MotionState{.counts = state_.counts};
}

void VertexMotion::Resume(MotionState state) {
  state_ = std::move(state);
  topology_ = field_.topology();
}

MotionCounts VertexMotion::Move(std::span<const glm::dvec3> gradients, double rate) {
  if (!IsArticle()) return field_.MoveVertices(SafeMoves(gradients, rate));
  const std::vector<glm::vec3> moves =
      ArticleMoves(gradients, rate * field_.subject_size(), state_);
  field_.MoveVerticesFreely(moves);
  const auto moved = [](const glm::vec3& move) { return move != glm::vec3(0.0f); };
  return {.moved = uint64_t(std::count_if(moves.begin(), moves.end(), moved))};
}

std::vector<glm::vec3> VertexMotion::SafeMoves(std::span<const glm::dvec3> gradients, double rate) {
  ++state_.motions;
  const double correction1 = 1.0 / (1.0 - std::pow(double(kBeta1), double(state_.motions)));
  const double correction2 = 1.0 / (1.0 - std::pow(double(kBeta2), double(state_.motions)));
  const float scale = float(rate * correction1 / std::sqrt(correction2));
  std::vector<glm::vec3> moves(gradients.size(), glm::vec3(0.0f));
  for (size_t v = 0; v < moves.size(); ++v) {
    const glm::vec3 gradient(gradients[v]);
    if (gradient == glm::vec3(0.0f)) continue;  // no ray has passed
    glm::vec3& first = state_.first_moment[v];
    first = glm::mix(gradient, first, kBeta1);
    state_.second_moment[v] = glm::mix(gradient * gradient, state_.second_moment[v], kBeta2);
    // Of the squared length, so that the move has the direction of the gradient.
    const float second = glm::dot(state_.second_moment[v], glm::vec3(1.0f));
    if (!(second > 0.0f)) continue;
    const glm::vec3 move = -scale * state_.size[v] / std::sqrt(second) * first;
    const float length = glm::length(move);
    if (!(length < state_.room[v])) continue;
    state_.room[v] -= length;
    moves[v] = move;
  }
  return moves;
}

}  // namespace tetrec
