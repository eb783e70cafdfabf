// How the DiffTetVR article moves vertices.
#include "optimize/article_motion.h"

#include <algorithm>
#include <cmath>

namespace tetrec {
namespace {

constexpr double kArticleBeta1 = 0.9, kArticleBeta2 = 0.999, kEpsilon = 1e-12;

}  // namespace

bool IsInJointEpoch(uint64_t step, size_t views) {
  return (step - 1) / std::max<size_t>(views, 1) % 2 == 1;
}

std::vector<glm::vec3> ArticleMoves(std::span<const glm::dvec3> gradients, double rate,
                                    MotionState& state) {
  ++state.motions;
  const double correction1 = 1.0 / (1.0 - std::pow(kArticleBeta1, double(state.motions)));
  const double correction2 = 1.0 / (1.0 - std::pow(kArticleBeta2, double(state.motions)));
  std::vector<glm::vec3> moves(gradients.size(), glm::vec3(0.0f));
  for (size_t v = 0; v < moves.size(); ++v) {
    if (state.room[v] <= 0.0f) continue;
    for (int i = 0; i < 3; ++i) {
      const double gradient = gradients[v][i];
      float& first = state.first_moment[v][i];
      float& second = state.second_moment[v][i];
      first = float(kArticleBeta1 * first + (1 - kArticleBeta1) * gradient);
      second = float(kArticleBeta2 * second + (1 - kArticleBeta2) * gradient * gradient);
      moves[v][i] =
          float(-rate * correction1 * first / (std::sqrt(correction2 * second) + kEpsilon));
    }
    const float length = glm::length(moves[v]);
    if (length >= state.room[v]) {
      moves[v] = glm::vec3(0.0f);
    } else {
      state.room[v] -= length;
    }
  }
  return moves;
}

}  // namespace tetrec
