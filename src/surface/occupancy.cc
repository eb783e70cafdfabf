// The function whose level set is the surface.
#include "surface/occupancy.h"

#include <algorithm>
#include <cmath>

namespace tetrec {
namespace {

// For signed density. With a larger number, values of opposite sign place the surface more exactly,
// but outliers count for more; 5 is best on the demo's surface, by far.
constexpr double kIsovaluesToSaturate = 5;

std::vector<float> AveragedWithNeighbors(const TetMesh& mesh, const std::vector<float>& values) {
  std::vector<double> sums(values.size(), 0.0);
  std::vector<uint32_t> counts(values.size(), 0);
  for (const glm::uvec4& tet : mesh.tets) {
    double sum = 0;
    for (int i = 0; i < 4; ++i) sum += values[tet[i]];
    for (int i = 0; i < 4; ++i) {
      sums[tet[i]] += sum - values[tet[i]];
      counts[tet[i]] += 3;
    }
  }
  std::vector<float> averaged = values;
  for (size_t v = 0; v < values.size(); ++v) {
    if (counts[v] > 0) averaged[v] = float(0.5 * (values[v] + sums[v] / counts[v]));
  }
  return averaged;
}

}  // namespace

std::vector<float> SmoothedOccupancy(const TetMesh& mesh, std::span<const float> density,
                                     double isovalue, int rounds) {
  std::vector<float> occupancy;
  occupancy.reserve(density.size());
  const bool is_signed = std::any_of(density.begin(), density.end(), [](float d) { return d < 0; });
  for (const float d : density) {
    const double x = (d / isovalue - 1) / kIsovaluesToSaturate;
    occupancy.push_back(float(is_signed ? 0.5 * (1 + x / (1 + std::abs(x))) : d / (d + isovalue)));
  }
  for (int round = 0; round < rounds; ++round) occupancy = AveragedWithNeighbors(mesh, occupancy);
  return occupancy;
}

}  // namespace tetrec
