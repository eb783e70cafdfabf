// What both readers of COLMAP models expect of the values.
#include "scene/colmap_checks.h"

#include "scene/checked_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tetrec::internal {
namespace {

constexpr uint64_t kMaxSide_px = 1 << 16;
constexpr double kFarthest = 1e12;
constexpr double kQuaternionTolerance = 1e-3;  // COLMAP normalises; further off is no rotation

}  // namespace

std::span<const ColmapLensKind> ColmapLensKinds() {
  static constexpr ColmapLensKind kKinds[] = {{"SIMPLE_PINHOLE", 1, 3},
                                              {"PINHOLE", 2, 4},
                                              {"SIMPLE_RADIAL", 1, 4},
                                              {"RADIAL", 1, 5},
                                              {"OPENCV", 2, 8},
                                              {"OPENCV_FISHEYE", 2, 8},
                                              {"FULL_OPENCV", 2, 12},
                                              {"FOV", 2, 5},
                                              {"SIMPLE_RADIAL_FISHEYE", 1, 4},
                                              {"RADIAL_FISHEYE", 1, 5},
                                              {"THIN_PRISM_FISHEYE", 2, 12},
                                              {"RAD_TAN_THIN_PRISM_FISHEYE", 2, 16},
                                              {"SIMPLE_DIVISION", 1, 4},
                                              {"DIVISION", 2, 5},
                                              {"SIMPLE_FISHEYE", 1, 3},
                                              {"FISHEYE", 2, 4},
                                              {"EUCM", 2, 6}};
  return kKinds;
}

std::string ComplaintOnLens(const std::string& lens) {
  std::string names;
  for (const ColmapLensKind& kind : ColmapLensKinds()) {
    names += fmt::format("{}{}", names.empty() ? "" : ", ", kind.name);
  }
  return fmt::format(
      "camera model {} is not known (0 to {}: {}); make pictures with PINHOLE cameras of these by "
      "image_undistorter of the COLMAP that wrote them",
      lens, ColmapLensKinds().size() - 1, names);
}

bool IsSane(double value) { return std::abs(value) <= kFarthest; }

std::string ComplaintOnSize(uint64_t width, uint64_t height) {
  if (std::min(width, height) >= 1 && std::max(width, height) <= kMaxSide_px) return "";
  return fmt::format("a camera has {} x {} pixels", width, height);
}

std::string ComplaintOnParams(const ColmapCamera& camera) {
  const std::vector<double>& p = camera.params;
  const bool has_one = ColmapLensKinds()[size_t(camera.model)].focal_lengths == 1;
  const double least = has_one ? p[0] : std::min(p[0], p[1]);
  if (!(least > 0)) return fmt::format("a camera has the focal length {} px", least);
  if (camera.model == kColmapEucm && !(p[4] >= 0 && p[4] <= 1 && p[5] > 0)) {
    return fmt::format(
        "an EUCM camera has alpha {} and beta {}; expected alpha 0 to 1 and beta above 0", p[4],
        p[5]);
  }
  return "";
}

std::string ComplaintOnQuaternion(const double (&wxyz)[4]) {
  double squared = 0;
  for (const double component : wxyz) squared += component * component;
  if (std::abs(squared - 1) <= kQuaternionTolerance) return "";
  return fmt::format("a quaternion has the squared length {}", squared);
}

std::string ComplaintOnPictureName(const std::string& name) {
  // Files are written under these names.
  if (StaysInside(name)) return "";
  return fmt::format("the picture name \"{}\" is no relative path", name);
}

Rigid3 PoseOf(const double (&wxyz)[4], const glm::dvec3& translation) {
  const glm::dquat quaternion(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
  return {glm::mat3_cast(glm::normalize(quaternion)), translation};
}

}  // namespace tetrec::internal
