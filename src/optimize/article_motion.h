// How the DiffTetVR article moves vertices (section 6 and its public training script): for
// comparison, since nothing keeps tets from turning inside out.
//
// Epochs alternate, each of as many steps as there are training pictures: colour and density alone,
// then positions, too. In these, every step moves every vertex by Adam on each coordinate (Kingma
// and Ba 2015), with a rate that is one length for the whole mesh.
#pragma once

#include "optimize/vertex_motion.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace tetrec {

// Whether positions are learned in step `step`, counted from 1.
bool IsInJointEpoch(uint64_t step, size_t views);

// (V) The moves [world units] by the gradients (V) of one step, whose moments the state gets.
// Vertices that would have moved farther than their room stay; those of the boundary have none.
//   rate  Adam's step [world units]
std::vector<glm::vec3> ArticleMoves(std::span<const glm::dvec3> gradients, double rate,
                                    MotionState& state);

}  // namespace tetrec
