// Scales of the fixed-point sums of deterministic rendering.
#pragma once

#include "mesh/tet_mesh.h"

#include <cstdint>

namespace tetrec {

// A sum is a 64-bit count of quanta. A vertex gets at most one addend from a ray for each of the
// vertex's tets, so with R rays and at most N tets around a vertex, addends of up to
// L = 2^62 / (B R N) quanta can never make it overflow in B = kMostSummedBatches batches; larger
// ones are clamped and counted.
//
// With g the scale of the rays' own gradients (dL/dresidual is at most a few g) and D the diagonal
// of the mesh's bounds, a ray's addend is about g for colour, g x length for density, g / length
// for position. L represents 2^6 g, 2^6 g D and 2^24 g / D: positions need the room because hits on
// faces seen at a flat angle move far. In a step of 4,096 rays (N = 128: L = 2^39) the quanta are
// 2^-33 g, 2^-33 g D and 2^-15 g / D, where tets of a hundredth of D give gradients of 2^-7 g D and
// 2^7 g / D: an addend of 10^-5 of a whole ray's is kept with 16 bits for colour, 9 for density, 5
// for position.
struct FixedPoint {
  float color_quanta = 1, density_quanta = 1, position_quanta = 1;  // per unit; powers of two
  float largest_quanta = 0;                                         // L
  bool operator==(const FixedPoint&) const = default;
};

// `gradient_scale` is g, `rays` is R.
FixedPoint ChooseFixedPoint(double gradient_scale, uint64_t rays, uint32_t most_tets_at_vertex,
                            double diagonal);

// N of the mesh: the largest number of tets around a vertex.
uint32_t MostTetsAtVertex(const TetMesh& mesh);

}  // namespace tetrec
