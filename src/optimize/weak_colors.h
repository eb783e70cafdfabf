// Colours that hardly any ray determines. Vertices beside what the photos show have a small weight
// in a few of their rays, and Adam moves them as fast as all others: in a long run their colours
// drift to whatever suits these rays, and an unseen view that shows more of them is spoiled.
#pragma once

#include "field/field_state.h"
#include "optimize/batches.h"
#include "optimize/training_set.h"
#include "render/training_renderer.h"

#include <cstdint>
#include <span>
#include <vector>

namespace tetrec {

// A look at the evidence takes about as long as the steps that learn each pixel once. It is worth
// that after so many times as many rays.
inline constexpr double kPassesOfDrift = 30;

// (V) For each vertex the sum, over the rays of all training pixels, of the squared share that its
// colour has in what the ray shows: how well the pixels determine that colour. An estimate, from
// gradients of the absolute error, whose signs are random once a field has been learned. Gradients
// that wait in the renderer for an update are lost. Not for batches that must be tiles.
std::vector<float> LookAtColorEvidence(TrainingRenderer& renderer, const TrainingSet& set,
                                       const BatchDrawer& batches, uint64_t seed);

// Lets the colours and harmonics of vertices with little evidence follow their neighbours: each
// becomes the mean of what it was, weighted by its evidence, and of the mean of its neighbours,
// weighted by kPriorEvidence, in some sweeps over all vertices. Neighbours count by their nearness
// and their own evidence. The field has its values at vertices.
void SmoothWeakColors(const TetMesh& mesh, std::span<const float> evidence, FieldState& state);

// How much of a ray the neighbours count for. Pictures differ from the field by some 0.02 [display
// sRGB], and neighbouring colours by 0.1 to 0.3. With (0.02 / 0.1)^2, views of the demo that show
// nothing new lose 0.15 dB; with a tenth of it they lose nothing.
inline constexpr double kPriorEvidence = 0.005;

}  // namespace tetrec
