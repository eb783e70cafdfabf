// A field's attributes moved from vertices to tets, and back.
#pragma once

#include "field/radiance_field.h"

namespace tetrec {

// The field itself where it is stored so. To cells: a tet's density is the mean of the linear field
// in it, its colour that of its vertices, each weighted by its density. To vertices: a vertex's
// density is the mean of the cells around it, weighted by volume; its colour the mean weighted by
// volume and density. Where all that density is 0, colours are weighted without it.
RadianceField WithStorage(const RadianceField& field, FieldStorage storage);

}  // namespace tetrec
