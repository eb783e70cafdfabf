// True depths of views: of a true mesh, or of depth maps that a data set has.
#pragma once

#include "geometry/bounds3.h"
#include "geometry/camera.h"
#include "geometry/rigid3.h"
#include "image/depth_map.h"
#include "mesh/triangle_mesh.h"

#include <filesystem>
#include <string>

namespace tetrec {

// The depth of the mesh through each pixel's centre [world units], by a z-buffer; no depth where
// the nearest point lies outside of `bounds_in_truth`. Triangles that reach behind the camera are
// left out and counted.
struct MeshDepth {
  DepthMap map;
  size_t cut_triangles = 0;
};
MeshDepth DepthOfMesh(const TriangleMesh& mesh_in_truth, const Similarity3& truth_from_world,
                      const Bounds3& bounds_in_truth, const Camera& camera,
                      const Rigid3& cam_from_world);

// The true depth of a NeRF-synthetic view "test/r_0" from FOLDER/test/r_0_depth_0001.png (any
// number), interpolated at the centres of the camera's pixels [world units]. The data set's value v
// of 255 means a distance of 8 (1 - v / 255) [input units] along the ray, in steps of 0.03; 0 is
// the background. (Found by projecting each map of lego into the others: half of the pixels agree
// within half a step, for no other range, direction or measure within several.) No depth where a
// neighbour shows the background or differs by more than 4 steps: such edges may be averages of
// both sides. Throws DataError.
DepthMap ReadNerfDepth(const std::filesystem::path& folder, const std::string& view_name,
                       const Camera& camera, double world_from_input_scale);

// FOLDER/test/r_0_WHAT_0001.png of a NeRF-synthetic view "test/r_0", whatever its number. Throws
// DataError if there is none.
std::filesystem::path NerfMapFile(const std::filesystem::path& folder, const std::string& view_name,
                                  const std::string& what);

}  // namespace tetrec
