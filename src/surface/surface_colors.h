// The colours of a surface's points.
#pragma once

#include "image/image.h"
#include "mesh/triangle_mesh.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace tetrec {

// The colour [display sRGB, 0 to 1] of the point of a triangle at which its corners have these
// shares.
using SurfaceColors = std::function<glm::vec3(uint32_t triangle, const glm::vec3& shares)>;

// Linear between the vertices, or bilinear between the centres of the texels. All arguments must
// outlive the result.
SurfaceColors ColorsOfVertices(const TriangleMesh& mesh, std::span<const glm::vec3> colors);
SurfaceColors ColorsOfTexture(const TriangleMesh& mesh, const Image& texture);

// (V) [display sRGB, 0 to 1]; grey for a mesh without colours.
std::vector<glm::vec3> VertexColors(const TriangleMesh& mesh);

}  // namespace tetrec
