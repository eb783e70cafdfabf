// Cameras that stand inside of opaque density, and so see nothing else.
#pragma once

#include "field/radiance_field.h"
#include "scene/scene.h"

#include <string>
#include <vector>

namespace tetrec {

// The names of the views around whose camera the density is so high that a ray loses half of its
// light within a tenth of the distance to the nearest thing that the view shows: its nearest points
// (their depth's 5 % quantile), or, with fewer than 10, the subject's bounds. A camera inside these
// bounds without such points is not judged.
std::vector<std::string> BuriedCameras(const RadianceField& field, const Scene& scene);

}  // namespace tetrec
