// Scales of the fixed-point sums of deterministic rendering.
#include "render/vulkan/fixed_point.h"

#include "render/training_renderer.h"

#include <algorithm>
#include <cmath>

namespace tetrec {
namespace {

// The largest power of two that does not exceed x.
double PowerBelow(double x) { return std::exp2(std::floor(std::log2(x))); }

}  // namespace

FixedPoint ChooseFixedPoint(double gradient_scale, uint64_t rays, uint32_t most_tets_at_vertex,
                            double diagonal) {
  const double scale = std::max(gradient_scale, 0x1p-60);  // keeps the quanta within float's range
  const double largest =
      PowerBelow(0x1p62 / (double(kMostSummedBatches) * double(rays) * most_tets_at_vertex));
  return {float(PowerBelow(largest / (0x1p6 * scale))),
          float(PowerBelow(largest / (0x1p6 * scale * diagonal))),
          float(PowerBelow(largest / (0x1p24 * scale / diagonal))), float(largest)};
}

uint32_t MostTetsAtVertex(const TetMesh& mesh) {
  std::vector<uint32_t> counts(mesh.positions.size());
  for (const glm::uvec4& tet : mesh.tets) {
    for (int i = 0; i < 4; ++i) ++counts[tet[i]];
  }
  return counts.empty() ? 1 : std::max(1u, *std::max_element(counts.begin(), counts.end()));
}

}  // namespace tetrec
