// A surface is cut into charts: connected parts that can be laid flat.
#pragma once

#include "mesh/triangle_mesh.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <vector>

namespace tetrec {

// Triangles that face roughly the same way, and the axes of the plane that they are projected to.
// Seen against x cross y they are counter-clockwise, and none covers another.
struct TextureChart {
  std::vector<uint32_t> triangles;
  glm::dvec3 x{1, 0, 0}, y{0, 1, 0};  // unit vectors, perpendicular

  glm::dvec2 InPlane(const glm::vec3& position) const {
    const glm::dvec3 p(position);
    return {glm::dot(x, p), glm::dot(y, p)};
  }
};

// Every triangle is in one chart. Triangles without area are in charts, too, where they may lie
// across others, because they show nothing.
//
// Charts grow from large triangles over neighbours whose smoothed normals agree with the chart's;
// then the plane is fixed, and what would fold over or cover another triangle goes to later charts.
std::vector<TextureChart> CutIntoCharts(const TriangleMesh& mesh);

}  // namespace tetrec
