// Start meshes of bad shape, as a starting field for tetrec-optimize.
#pragma once

#include "field/radiance_field.h"
#include "geometry/bounds3.h"

#include <cstddef>

namespace tetrec {

// Splits `count` tets inside the bounds, spread evenly over their list, by a vertex that is almost
// on a face, so that each leaves a sliver of 1e-4 of its height; the field stays as it is. Requires
// values at vertices. Throws DataError if fewer tets can be split.
void AddSlivers(RadianceField& field, const Bounds3& bounds, size_t count);

// Replaces the vertices inside a ball, of 0.8 of the bounds' shortest half side, by the corners of
// one regular tet; each takes the values of the nearest vertex that was dropped. Requires values at
// vertices. Throws DataError if no vertex is in the ball.
void ReplaceMiddleByOneTet(RadianceField& field, const Bounds3& bounds);

}  // namespace tetrec
