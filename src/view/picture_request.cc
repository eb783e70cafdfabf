// Queries to requests. They come from outside.
#include "view/picture_request.h"

#include "core/error.h"
#include "geometry/look_at.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>

namespace tetrec {
namespace {

using Query = std::map<std::string, std::string>;

constexpr double kFarthest = 1e6;  // [world units]

const std::string& ValueOf(const Query& query, const std::string& name) {
  const auto found = query.find(name);
  if (found == query.end()) throw UsageError(name + " is missing");
  return found->second;
}

double ParseNumber(const std::string& name, std::string_view text, double least, double most) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool is_number = error == std::errc() && end == text.data() + text.size();
  if (!is_number || !(value >= least && value <= most)) {
    throw UsageError(fmt::format("{} is '{}'; expected a number from {} to {}", name,
                                 text.substr(0, 40), least, most));
  }
  return value;
}

double NumberOf(const Query& query, const std::string& name, double least, double most) {
  return ParseNumber(name, ValueOf(query, name), least, most);
}

int IntegerOf(const Query& query, const std::string& name, int least, int most) {
  const double value = NumberOf(query, name, least, most);
  if (value != std::floor(value)) {
    throw UsageError(fmt::format("{} is {}; expected a whole number", name, value));
  }
  return int(value);
}

glm::dvec3 VectorOf(const Query& query, const std::string& name) {
  std::string_view rest = ValueOf(query, name);
  glm::dvec3 result;
  for (int i = 0; i < 3; ++i) {
    const size_t comma = rest.find(',');
    if ((comma == rest.npos) != (i == 2)) {
      throw UsageError(fmt::format("{} is '{}'; expected three numbers with commas between them",
                                   name, ValueOf(query, name).substr(0, 80)));
    }
    result[i] = ParseNumber(name, rest.substr(0, comma), -kFarthest, kFarthest);
    if (comma != rest.npos) rest.remove_prefix(comma + 1);
  }
  return result;
}

glm::dvec3 DirectionOf(const Query& query, const std::string& name) {
  const glm::dvec3 direction = VectorOf(query, name);
  if (!(glm::length(direction) > 1e-6)) {
    throw UsageError(fmt::format("{} is '{}'; expected a direction, which is not zero", name,
                                 ValueOf(query, name)));
  }
  return glm::normalize(direction);
}

PictureMode ModeOf(const Query& query) {
  const std::string& word = ValueOf(query, "mode");
  if (const auto mode = FromName<PictureMode>(word)) return *mode;
  throw UsageError(fmt::format("mode is '{}', which is not one of the page's", word.substr(0, 40)));
}

// The camera with its image scaled to fit into a rectangle.
Camera FittedInto(const Camera& camera, int width, int height) {
  const double scale = std::min(double(width) / camera.width, double(height) / camera.height);
  const auto side = [&](int of) { return std::max(1, int(std::lround(scale * of))); };
  return camera.Resized(side(camera.width), side(camera.height));
}

RenderView FreeView(const Query& query, int width, int height) {
  const double fov_deg = NumberOf(query, "fov", 1, 170);
  const double focal = 0.5 * height / std::tan(0.5 * fov_deg * std::numbers::pi / 180);
  const glm::dvec3 eye = VectorOf(query, "eye");
  const glm::dmat3 rotation =
      CamFromWorldRotation(DirectionOf(query, "forward"), DirectionOf(query, "up"));
  return {{width, height, focal, focal, 0.5 * width, 0.5 * height}, {rotation, -(rotation * eye)}};
}

}  // namespace

PictureRequest ParsePictureRequest(const Query& query, const Scene& scene) {
  PictureRequest request;
  request.mode = ModeOf(query);
  const int width = IntegerOf(query, "w", kSmallestPicture_px, kLargestPicture_px);
  const int height = IntegerOf(query, "h", kSmallestPicture_px, kLargestPicture_px);
  request.is_draft = query.contains("draft") && IntegerOf(query, "draft", 0, 1) == 1;
  if (request.mode == PictureMode::kSlice) {
    request.slice_depth = NumberOf(query, "slice", 1e-6, kFarthest);
  }
  if (query.contains("view")) {
    request.view = IntegerOf(query, "view", 0, int(scene.views.size()) - 1);
    const View& view = scene.views[size_t(*request.view)];
    request.from = {FittedInto(scene.cameras[size_t(view.camera)], width, height),
                    view.cam_from_world};
    return request;
  }
  if (request.mode == PictureMode::kPhoto || request.mode == PictureMode::kError) {
    throw UsageError(fmt::format("mode is {}, which needs a view", Name(request.mode)));
  }
  request.from = FreeView(query, width, height);
  return request;
}

}  // namespace tetrec
