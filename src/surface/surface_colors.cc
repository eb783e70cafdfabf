// Interpolation between vertices or texels.
#include "surface/surface_colors.h"

#include "image/pixels_around.h"

namespace tetrec {

SurfaceColors ColorsOfVertices(const TriangleMesh& mesh, std::span<const glm::vec3> colors) {
  return [&mesh, colors](uint32_t triangle, const glm::vec3& shares) {
    const glm::uvec3& t = mesh.triangles[triangle];
    return shares.x * colors[t.x] + shares.y * colors[t.y] + shares.z * colors[t.z];
  };
}

SurfaceColors ColorsOfTexture(const TriangleMesh& mesh, const Image& texture) {
  return [&mesh, &texture](uint32_t triangle, const glm::vec3& shares) {
    const auto& corners = mesh.corner_coordinates[triangle];
    const glm::vec2 place = shares.x * corners[0] + shares.y * corners[1] + shares.z * corners[2];
    glm::vec3 color(0.0f);
    for (const auto& [x, y, weight] :
         PixelsAround(texture.width, texture.height,
                      {place.x * float(texture.width), (1 - place.y) * float(texture.height)})) {
      if (weight == 0) continue;
      const uint8_t* rgb = texture.At(x, y);
      color += float(weight) / 255 * glm::vec3(rgb[0], rgb[1], rgb[2]);
    }
    return color;
  };
}

std::vector<glm::vec3> VertexColors(const TriangleMesh& mesh) {
  if (mesh.colors_srgb.empty()) return std::vector(mesh.positions.size(), glm::vec3(128 / 255.0f));
  std::vector<glm::vec3> colors;
  colors.reserve(mesh.colors_srgb.size());
  for (const auto& rgb : mesh.colors_srgb) {
    colors.push_back(glm::vec3(rgb[0], rgb[1], rgb[2]) / 255.0f);
  }
  return colors;
}

}  // namespace tetrec
