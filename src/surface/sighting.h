// Points of a surface, and where photos see them.
#pragma once

#include "mesh/triangle_mesh.h"
#include "surface/texture_photos.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace tetrec {

// In world coordinates.
struct SurfacePoint {
  glm::dvec3 position, normal;
};

// What is interpolated between the vertices of a mesh, whose triangles' corners have `weights`.
class SurfacePoints {
 public:
  // The mesh must outlive this.
  explicit SurfacePoints(const TriangleMesh& mesh_in_world);

  SurfacePoint At(uint32_t triangle, const glm::dvec3& weights) const;
  glm::dvec3 ColorAt(uint32_t triangle, const glm::dvec3& weights) const;  // [display sRGB, 0 to 1]

 private:
  const TriangleMesh& mesh_;
  std::vector<glm::dvec3> normals_;
};

struct Sighting {
  glm::dvec2 pixel{0.0};
  double footprint = 0;  // of a pixel on a surface that faces the camera [world units]
  double facing = 0;     // 1: from the front, 0: at the steepest slant that counts
};

// Nothing if the point is out of the photo, behind the surface that the photo shows, turned away
// or too slanted.
std::optional<Sighting> See(const SurfacePoint& point, const TexturePhoto& photo);

struct PhotosByTriangle {
  std::vector<std::vector<uint32_t>> photos;
  uint64_t limited = 0;  // triangles that are seen by more photos than are taken
};

// For each triangle the photos that show it, or a triangle with a vertex in common: of a triangle
// with sides of less than 8 pixels at most 24, those that see its centre with the most pixels.
// FindTrust must have seen the same mesh.
PhotosByTriangle PhotosOfTriangles(const TriangleMesh& mesh_in_world,
                                   std::span<const TexturePhoto> photos);

}  // namespace tetrec
