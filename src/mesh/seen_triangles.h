// Which triangle of a mesh each pixel of a pinhole camera shows: a z-buffer on the CPU.
#pragma once

#include "geometry/camera.h"
#include "geometry/rigid3.h"
#include "mesh/triangle_mesh.h"

#include <glm/glm.hpp>

#include <array>
#include <cstdint>
#include <vector>

namespace tetrec {

inline constexpr uint32_t kNoTriangle = 0xFFFFFFFFu;

struct SeenTriangles {
  int width = 0, height = 0;
  std::vector<uint32_t> triangle;  // (height x width) nearest at the pixel's centre, or kNoTriangle
  std::vector<float> depth;        // (height x width) along z of the camera; infinite where none is

  size_t Index(int x, int y) const { return size_t(y) * size_t(width) + size_t(x); }
};

// Both sides of triangles are seen, and those that cross the camera's plane are cut off there.
// Method: Olano and Greer, Triangle Scan Conversion using 2D Homogeneous Coordinates, 1997.
SeenTriangles FindSeenTriangles(const TriangleMesh& mesh, const Camera& camera,
                                const Rigid3& cam_from_mesh);

// The weights of a triangle's corners at the point that the ray through a pixel position hits.
glm::dvec3 CornerWeights(const std::array<glm::dvec3, 3>& corners_in_cam, const Camera& camera,
                         const glm::dvec2& pixel);
glm::dvec3 CornerWeights(const TriangleMesh& mesh, uint32_t triangle, const Camera& camera,
                         const Rigid3& cam_from_mesh, const glm::dvec2& pixel);

}  // namespace tetrec
