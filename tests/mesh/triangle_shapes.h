// Triangle meshes of known shape.
#pragma once

#include "mesh/triangle_mesh.h"

#include <cmath>
#include <cstdint>

namespace tetrec {

inline TriangleMesh TestSphere(int rings, double radius,
                               const glm::dvec3& center = glm::dvec3(0.0)) {
  TriangleMesh mesh;
  const int sectors = 2 * rings;
  const auto add = [&](double polar, double around) {
    const glm::dvec3 n(std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around),
                       std::cos(polar));
    mesh.positions.push_back(glm::vec3(center + radius * n));
    mesh.colors_srgb.push_back(
        {uint8_t(127 + 120 * n.x), uint8_t(127 + 120 * n.y), uint8_t(127 + 120 * n.z)});
  };
  add(0, 0);
  for (int r = 1; r < rings; ++r) {
    for (int s = 0; s < sectors; ++s) add(M_PI * r / rings, 2 * M_PI * s / sectors);
  }
  add(M_PI, 0);
  const auto id = [&](int r, int s) { return uint32_t(1 + (r - 1) * sectors + s % sectors); };
  const auto last = uint32_t(mesh.positions.size() - 1);
  for (int s = 0; s < sectors; ++s) {
    mesh.triangles.push_back({0u, id(1, s), id(1, s + 1)});
    for (int r = 1; r + 1 < rings; ++r) {
      mesh.triangles.push_back({id(r, s), id(r + 1, s), id(r + 1, s + 1)});
      mesh.triangles.push_back({id(r, s), id(r + 1, s + 1), id(r, s + 1)});
    }
    mesh.triangles.push_back({id(rings - 1, s), last, id(rings - 1, s + 1)});
  }
  return mesh;
}

// A square [0, size]^2 at height z, of n x n x 2 triangles.
inline TriangleMesh Plane(int n, double size, double z) {
  TriangleMesh mesh;
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i)
      mesh.positions.emplace_back(float(size * i / n), float(size * j / n), float(z));
  }
  const auto id = [&](int i, int j) { return uint32_t(j * (n + 1) + i); };
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      mesh.triangles.emplace_back(id(i, j), id(i + 1, j), id(i + 1, j + 1));
      mesh.triangles.emplace_back(id(i, j), id(i + 1, j + 1), id(i, j + 1));
    }
  }
  return mesh;
}

}  // namespace tetrec
