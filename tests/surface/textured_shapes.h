// Shapes painted by a function of position, and photos of them in closed form.
#pragma once

#include "geometry/look_at.h"
#include "mesh/seen_triangles.h"
#include "mesh/triangle_mesh.h"
#include "surface/texture_photos.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

namespace tetrec {

// A colour in [0, 1] of each point of a surface.
using Paint = std::function<glm::dvec3(const glm::dvec3&)>;

// A cube [-1, 1]^3 with vertices of one grey.
inline TriangleMesh GreyCube() {
  TriangleMesh cube;
  for (int v = 0; v < 8; ++v) {
    cube.positions.emplace_back(v & 1 ? 1 : -1, v & 2 ? 1 : -1, v & 4 ? 1 : -1);
    cube.colors_srgb.push_back({128, 128, 128});
  }
  cube.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return cube;
}

// A wall and, in front of a part of it, a plate.
inline TriangleMesh WallBehindPlate() {
  TriangleMesh mesh;
  mesh.positions = {{-1, -1, 0},       {1, -1, 0},       {1, 1, 0},       {-1, 1, 0},
                    {-0.5f, -0.5f, 1}, {0.5f, -0.5f, 1}, {0.5f, 0.5f, 1}, {-0.5f, 0.5f, 1}};
  mesh.colors_srgb.assign(8, {128, 128, 128});
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}};
  return mesh;
}

// Waves in all directions, about 8 to an edge of the cube, far finer than its vertices.
inline glm::dvec3 Waves(const glm::dvec3& p) {
  return {0.5 + 0.4 * std::sin(12 * p.x + 5 * p.y), 0.5 + 0.4 * std::sin(12 * p.y + 7 * p.z),
          0.5 + 0.4 * std::sin(11 * p.z - 9 * p.x)};
}

// A photo towards the origin, with gain and offset in all channels.
inline TexturePhoto PhotoOf(const TriangleMesh& mesh, const Paint& paint, const glm::dvec3& eye,
                            double gain = 1, double offset = 0) {
  TexturePhoto photo;
  photo.camera = {160, 160, 220.0, 220.0, 80.0, 80.0};
  const glm::dvec3 forward = -glm::normalize(eye);
  const glm::dmat3 rotation = CamFromWorldRotation(
      forward, std::abs(forward.z) > 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, 1));
  photo.cam_from_world = {rotation, -(rotation * eye)};
  photo.gain = glm::dvec3(gain);
  photo.offset = glm::dvec3(offset);
  photo.image = MakeImage(photo.camera.width, photo.camera.height, 3);
  const SeenTriangles seen = FindSeenTriangles(mesh, photo.camera, photo.cam_from_world);
  for (int y = 0; y < seen.height; ++y) {
    for (int x = 0; x < seen.width; ++x) {
      const size_t i = seen.Index(x, y);
      if (seen.triangle[i] == kNoTriangle) continue;
      const glm::dvec3 in_cam =
          double(seen.depth[i]) * photo.camera.CamFromImage({x + 0.5, y + 0.5});
      const glm::dvec3 color = paint(photo.cam_from_world.Inverse() * in_cam);
      for (int c = 0; c < 3; ++c) {
        photo.image.At(x, y)[c] =
            uint8_t(std::lround(255 * std::clamp(gain * color[c] + offset, 0.0, 1.0)));
      }
    }
  }
  FindTrust(mesh, photo);
  return photo;
}

// From the middles of all sides and from all corners of a cube around the origin.
inline std::vector<TexturePhoto> PhotosAround(const TriangleMesh& mesh, const Paint& paint) {
  std::vector<TexturePhoto> photos;
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        const int nonzero = std::abs(x) + std::abs(y) + std::abs(z);
        if (nonzero != 1 && nonzero != 3) continue;
        const double gain = 0.7 + 0.05 * double(photos.size() % 5);
        photos.push_back(
            PhotoOf(mesh, paint, 4.5 * glm::normalize(glm::dvec3(x, y, z)), gain, 0.05));
      }
    }
  }
  return photos;
}

}  // namespace tetrec
