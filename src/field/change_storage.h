// Moves a field's attributes from vertices to tets, and back.
#pragma once

#include "field/radiance_field.h"

namespace tetrec {

// Returns the field itself if it is already stored so. To cells: a tet's density is the mean of the
// linear field in it, or 0 if that is negative, its other attributes are those of its vertices,
// each weighted by its density. To vertices: a vertex's density is the mean of the cells around it,
// weighted by volume; its other attributes are weighted by volume and density. Where all that
// density is 0, the weight leaves it out. Attributes of an exponential activation are treated as
// density is.
RadianceField WithStorage(RadianceField field, FieldStorage storage);

}  // namespace tetrec
