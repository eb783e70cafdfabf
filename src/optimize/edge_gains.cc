// What the image error would lose by a vertex in the middle of an edge.
#include "optimize/edge_gains.h"

#include "core/error.h"

#include <algorithm>
#include <limits>

namespace tetrec {

double GainOfStep(double slope, double curvature, double least, double most) {
  if (!(curvature > 0.0)) return 0.0;
  const double step = std::clamp(-slope / curvature, least, most);
  return -step * (slope + 0.5 * curvature * step);
}

std::vector<double> GainsOfEdges(const MeshEdges& edges, const FieldState& state,
                                 std::span<const EdgeSums> sums) {
  TETREC_CHECK(sums.size() == edges.ends.size(), "one sum per edge");
  const size_t components = size_t(state.layout.Components());
  const Attribute& density = state.layout.density();
  const double least_density = density.activation == Activation::kSigned
                                   ? ValueOf(density, double(kLeastSignedParameter))
                                   : 0.0;
  std::vector<double> gains;
  gains.reserve(sums.size());
  for (size_t e = 0; e < sums.size(); ++e) {
    const float* a = state.parameters.data() + edges.ends[e].x * components;
    const float* b = state.parameters.data() + edges.ends[e].y * components;
    double gain = 0.0;
    for (int c = 0; c < 3; ++c) {
      const double value =
          std::clamp(0.5 * (double(a[kColorOffset + c]) + double(b[kColorOffset + c])), 0.0, 1.0);
      gain += GainOfStep(sums[e].color[c], sums[e].color_curvature, -value, 1.0 - value);
    }
    const double value = 0.5 * (ValueOf(density, double(a[kDensityOffset])) +
                                ValueOf(density, double(b[kDensityOffset])));
    gain +=
        GainOfStep(sums[e].density, sums[e].density_curvature, std::min(least_density - value, 0.0),
                   std::numeric_limits<double>::infinity());
    gains.push_back(gain);
  }
  return gains;
}

}  // namespace tetrec
