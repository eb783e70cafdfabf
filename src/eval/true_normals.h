// True normals of views, from the normal maps that a data set has.
#pragma once

#include "geometry/camera.h"
#include "geometry/rigid3.h"
#include "image/normal_map.h"

#include <filesystem>
#include <string>

namespace tetrec {

// The true normals of a NeRF-synthetic view "test/r_0" from FOLDER/test/r_0_normal_0001.png (any
// number), at the centres of the camera's pixels, in the frame of the data set's cameras (input).
// The data set stores the positive part of x, y and z as display sRGB, and black for the
// background. (Found in lego's maps: flat faces have length 1 by this reading alone, and a face
// keeps its colour in all views.) One negative component follows from the length of the others. A
// pixel has no normal where several components may be negative, where it or a neighbour is black,
// where the stored pixels around its centre differ by more than 30 degrees from their mean, and
// where the result would face away from the camera: outlines and edges are averages of both sides.
// Throws DataError.
NormalMap ReadNerfNormals(const std::filesystem::path& folder, const std::string& view_name,
                          const Camera& camera, const glm::dmat3& input_from_cam);

}  // namespace tetrec
