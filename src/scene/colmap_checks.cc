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
  static constexpr ColmapLensKind kKinds[] = {{"SIMPLE_PINHOLE", 3},
                                              {"PINHOLE", 4},
                                              {"SIMPLE_RADIAL", 4},
                                              {"RADIAL", 5},
                                              {"OPENCV", 8},
                                              {"OPENCV_FISHEYE", 8},
                                              {"FULL_OPENCV", 12},
                                              {"FOV", 5},
                                              {"SIMPLE_RADIAL_FISHEYE", 4},
                                              {"RADIAL_FISHEYE", 5},
                                              {"THIN_PRISM_FISHEYE", 12}};
  return kKinds;
}

std::string ComplaintOnLens(const std::string& lens) {
  std::string names;
  for (const ColmapLensKind& kind : ColmapLensKinds()) {
    names += fmt::format("{}{}", names.empty() ? "" : ", ", kind.name);
  }
  return fmt::format(
      "camera model {} is not known; those of COLMAP up to 3.10 are read (0 to {}: {}); make "
      "pictures with PINHOLE cameras of these by image_undistorter of the COLMAP that wrote them",
      lens, ColmapLensKinds().size() - 1, names);
}

bool IsSane(double value) { return std::abs(value) <= kFarthest; }

std::string ComplaintOnSize(uint64_t width, uint64_t height) {
  if (std::min(width, height) >= 1 && std::max(width, height) <= kMaxSide_px) return "";
  return fmt::format("a camera has {} x {} pixels", width, height);
}

std::string ComplaintOnFocalLength(const ColmapCamera& camera) {
  const bool has_one = camera.model == kColmapSimplePinhole ||
                       camera.model == kColmapSimpleRadial || camera.model == kColmapRadial ||
                       camera.model == kColmapSimpleRadialFisheye ||
                       camera.model == kColmapRadialFisheye;
  const double least = has_one ? camera.params[0] : std::min(camera.params[0], camera.params[1]);
  if (least > 0) return "";
  return fmt::format("a camera has the focal length {} px", least);
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
