// True normals of views.
#include "eval/true_normals.h"

#include "eval/true_depth.h"
#include "image/image.h"
#include "image/pixels_around.h"
#include "image/srgb.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace tetrec {
namespace {

constexpr double kUnit = 0.01;       // of which a length may differ from 1; levels are 0.009 apart
constexpr double kAgreeing = 0.866;  // cosine of 30 degrees

glm::dvec3 StoredAt(const Image& map, int x, int y) {
  const uint8_t* rgb = map.At(x, y);
  return {LinearFromSrgb(rgb[0] / 255.0), LinearFromSrgb(rgb[1] / 255.0),
          LinearFromSrgb(rgb[2] / 255.0)};
}

bool HasBlackNeighbor(const Image& map, int x, int y) {
  for (int ny = std::max(y - 1, 0); ny <= std::min(y + 1, map.height - 1); ++ny) {
    for (int nx = std::max(x - 1, 0); nx <= std::min(x + 1, map.width - 1); ++nx) {
      const uint8_t* rgb = map.At(nx, ny);
      if (rgb[0] == 0 && rgb[1] == 0 && rgb[2] == 0) return true;
    }
  }
  return false;
}

// The normal of which only the positive part is stored; nothing if it is not known.
std::optional<glm::dvec3> Completed(glm::dvec3 positive) {
  const double squared = glm::dot(positive, positive), length = std::sqrt(squared);
  if (length > 1 + kUnit) return std::nullopt;
  if (length >= 1 - kUnit) return positive / length;
  int zeros = 0, zero = 0;
  for (int c = 0; c < 3; ++c) {
    if (positive[c] != 0) continue;
    ++zeros;
    zero = c;
  }
  if (zeros != 1) return std::nullopt;
  positive[zero] = -std::sqrt(1 - squared);
  return positive;
}

std::optional<glm::dvec3> NormalAt(const Image& map, const glm::dvec2& position) {
  glm::dvec3 sum(0.0);
  std::vector<glm::dvec3> around;
  for (const auto& [x, y, weight] : PixelsAround(map.width, map.height, position)) {
    if (weight == 0) continue;
    if (HasBlackNeighbor(map, x, y)) return std::nullopt;
    const auto normal = Completed(StoredAt(map, x, y));
    if (!normal) return std::nullopt;
    around.push_back(*normal);
    sum += weight * *normal;
  }
  const glm::dvec3 mean = glm::normalize(sum);
  const auto agrees = [&](const glm::dvec3& n) { return glm::dot(n, mean) > kAgreeing; };
  return std::all_of(around.begin(), around.end(), agrees) ? std::optional(mean) : std::nullopt;
}

}  // namespace

NormalMap ReadNerfNormals(const std::filesystem::path& folder, const std::string& view_name,
                          const Camera& camera, const glm::dmat3& input_from_cam) {
  const Image stored = ReadImage(NerfMapFile(folder, view_name, "normal"));
  NormalMap map = MakeNormalMap(camera.width, camera.height);
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const auto normal = NormalAt(stored, {(x + 0.5) * stored.width / camera.width,
                                            (y + 0.5) * stored.height / camera.height});
      if (!normal) continue;
      const glm::dvec3 ray = input_from_cam * camera.CamFromImage({x + 0.5, y + 0.5});
      if (glm::dot(*normal, ray) < 0) map.At(x, y) = glm::vec3(*normal);
    }
  }
  return map;
}

}  // namespace tetrec
