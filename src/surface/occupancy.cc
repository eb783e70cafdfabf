// The function whose level set is the surface.
#include "surface/occupancy.h"

namespace tetrec {
namespace {

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
  for (const float d : density) occupancy.push_back(float(d / (std::abs(d) + isovalue)));
  for (int round = 0; round < rounds; ++round) occupancy = AveragedWithNeighbors(mesh, occupancy);
  return occupancy;
}

}  // namespace tetrec
