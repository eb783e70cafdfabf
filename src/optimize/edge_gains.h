// What the image error would lose by a vertex in the middle of an edge: a step by Newton's method,
// along gradient and curvature of the vertex' own colour and density.
#pragma once

#include "field/field_state.h"
#include "mesh/mesh_edges.h"
#include "render/training_renderer.h"

#include <span>
#include <vector>

namespace tetrec {

// What slope x + curvature x^2 / 2 loses at best for x in [least, most], which contains 0.
double GainOfStep(double slope, double curvature, double least, double most);

// Per edge, the gains of the three channels of colour and of density, none of which knows of the
// others. No step leads below density 0, or the least value of signed density, or out of the
// colours' range.
std::vector<double> GainsOfEdges(const MeshEdges& edges, const FieldState& state,
                                 std::span<const EdgeSums> sums);

}  // namespace tetrec
