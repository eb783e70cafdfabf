// Checks of values that the readers of COLMAP models share.
#include "colmap/checks.h"

#include "core/checked_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tetrec::internal {
namespace {

constexpr uint64_t kMaxSide_px = 1 << 16;
constexpr double kFarthest = 1e12;
constexpr double kQuaternionTolerance =
    1e-3;  // COLMAP normalises; farther off it is not a rotation

}  // namespace

std::string ComplaintOnUnknownModel(const std::string& model) {
  return ComplaintOnLensModel(model) +
         "; make PINHOLE images of these with image_undistorter of the COLMAP that wrote them";
}

bool IsSane(double value) { return std::abs(value) <= kFarthest; }

std::string ComplaintOnSize(uint64_t width, uint64_t height) {
  if (std::min(width, height) >= 1 && std::max(width, height) <= kMaxSide_px) return "";
  return fmt::format("a camera has {} x {} pixels", width, height);
}

std::string ComplaintOnQuaternion(const double (&wxyz)[4]) {
  double squared = 0;
  for (const double component : wxyz) squared += component * component;
  if (std::abs(squared - 1) <= kQuaternionTolerance) return "";
  return fmt::format("a quaternion has the squared length {}", squared);
}

std::string ComplaintOnImageName(const std::string& name) {
  // Files are written under these names.
  if (StaysInside(name)) return "";
  return fmt::format("the image name \"{}\" is not a relative path inside the folder", name);
}

Rigid3 PoseOf(const double (&wxyz)[4], const glm::dvec3& translation) {
  const glm::dquat quaternion(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
  return {glm::mat3_cast(glm::normalize(quaternion)), translation};
}

}  // namespace tetrec::internal
