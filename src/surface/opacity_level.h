// The surface where cameras see it: the level set of how far points are behind what stops rays.
#pragma once

#include "geometry/camera.h"
#include "geometry/rigid3.h"
#include "image/depth_map.h"
#include "mesh/tet_mesh.h"
#include "surface/marching_tetrahedra.h"

#include <glm/glm.hpp>

#include <span>

namespace tetrec {

// A camera, and where its rays are stopped.
struct SeenDepth {
  Camera camera;
  Rigid3 cam_from_world;
  DepthMap depth;  // of the camera's size, 2 x 2 pixels or more; kNoDepth: the ray is never stopped
  // Of the same size, or empty. The depth up to which a ray is free, if nothing is known about it
  // beyond that depth; kNoDepth for all other rays.
  DepthMap free_until;
};

// How solid space is at a point, from -1 (free) to 1; 0 at the surface. A camera
// contributes how far the point is behind where its ray is stopped, up to a band of a few pixels,
// near whose end it counts less. Cameras from which the point is farther behind see something else
// in front of it and do not count, nor do those whose rays are not known there; a point that
// is so hidden from all cameras is solid, and one that is outside of all images is free. Methods:
// Yu et al., Gaussian Opacity Fields, 2024 (opacity along rays as the level, but its minimum over
// the views, which one wrong view decides); Curless and Levoy, A Volumetric Method for Building
// Complex Models from Range Images, 1996 (mean over the views).
double SolidityAt(const glm::dvec3& point_in_world, std::span<const SeenDepth> views);

// {x : SolidityAt(x) = 0} as far as the mesh resolves it: marching tetrahedra of the values at the
// vertices, whose cuts then move along their edges to where the function itself is 0.
LevelSet MarchToOpacity(const TetMesh& mesh, std::span<const SeenDepth> views);

// Without what only separates space that some camera sees to be free from space that is hidden from
// all of them. A vertex is seen if the rays of cameras that it faces, from 12 degrees above the
// surface or more, end near it: of one camera in ten, one at least and three at most. A triangle is
// seen if two of its vertices are. Connected patches of unseen triangles whose boxes have diagonals
// of up to `largest_gap` [world units] stay: they close gaps in what is seen, where depths of
// different cameras disagree. So do patches of which less than a tenth of the area has no ray that
// ends near it, and parts of patches that fill gaps of up to `largest_gap` between what is kept.
// Last, strips narrower than a fifth of `largest_gap`, or than two triangles, are dropped: rags
// that hang from a border, but also thin things of which cameras see one side only.
LevelSet SeenPart(const LevelSet& set, std::span<const SeenDepth> views, double largest_gap);

}  // namespace tetrec
