// Umeyama's fit of camera centres.
#include "eval/alignment.h"

#include "core/error.h"
#include "core/file.h"
#include "geometry/checked_geometry.h"
#include "image/file_names.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace tetrec {
namespace {

using Points = Eigen::Matrix3Xd;

Points AsColumns(std::span<const glm::dvec3> points) {
  Points columns(3, Eigen::Index(points.size()));
  for (size_t i = 0; i < points.size(); ++i) {
    columns.col(Eigen::Index(i)) << points[i].x, points[i].y, points[i].z;
  }
  return columns;
}

// Throws unless the points span a plane: the second singular value must exceed rounding errors and
// the sideways spread of a straight hand-held walk (a thousandth of its length).
void CheckSpread(const Points& points, const char* what) {
  const Points centered = points.colwise() - points.rowwise().mean();
  const Eigen::Vector3d spread = Eigen::JacobiSVD<Points>(centered).singularValues();
  if (!(spread[0] > 0) || spread[1] < 1e-3 * spread[0]) {
    throw DataError(fmt::format(
        "{} are on one line or at one point (spread {:.3g}, {:.3g}), which allows no alignment",
        what, spread[0], spread[1]));
  }
}

// "a/b" is a tail of "x/a/b" and of itself, not of "xa/b".
bool IsTail(const std::string& tail, const std::string& path) {
  return path.ends_with(tail) &&
         (path.size() == tail.size() || path[path.size() - tail.size() - 1] == '/');
}

bool SameImage(const std::string& a, const std::string& b) {
  const std::string x = WithoutImageExtension(a), y = WithoutImageExtension(b);
  return IsTail(x, y) || IsTail(y, x);
}

// Null if no camera's file matches the view's name; throws DataError if two do.
template <class Matches>
const TrueCamera* FindOnly(const View& view, std::span<const TrueCamera> cameras,
                           const Matches& matches) {
  const TrueCamera* found = nullptr;
  for (const TrueCamera& camera : cameras) {
    if (!matches(view.name, camera.file)) continue;
    if (found) {
      throw DataError(
          fmt::format("view '{}' matches two true cameras, '{}' and '{}'; give their full names",
                      view.name, found->file, camera.file));
    }
    found = &camera;
  }
  return found;
}

// Equal names count before tails: "a.jpg" is a tail of "x/a.jpg".
const TrueCamera* FindCamera(const View& view, std::span<const TrueCamera> cameras) {
  const TrueCamera* same = FindOnly(view, cameras, std::equal_to<std::string>());
  return same ? same : FindOnly(view, cameras, SameImage);
}

double AngleDegrees(const glm::dmat3& a, const glm::dmat3& b) {
  const glm::dmat3 difference = glm::transpose(a) * b;
  const double trace = difference[0][0] + difference[1][1] + difference[2][2];
  return std::acos(std::clamp((trace - 1) / 2, -1.0, 1.0)) * 180 / M_PI;
}

// Three rows [R | t].
Rigid3 ReadPose(const CheckedJson& rows) {
  Rigid3 pose;
  if (rows.Size() != 3) rows.Fail(fmt::format("has {} rows; expected 3", rows.Size()));
  for (size_t r = 0; r < 3; ++r) {
    const CheckedJson row = rows.Item(r);
    if (row.Size() != 4) row.Fail(fmt::format("has {} numbers; expected 4", row.Size()));
    for (size_t c = 0; c < 3; ++c) pose.rotation[int(c)][int(r)] = row.Item(c).Number();
    pose.translation[int(r)] = row.Item(3).Number();
  }
  // The files have nine digits; a larger error means that this is another kind of matrix.
  CheckedRotation(pose.rotation, 1e-3, rows);
  return pose;
}

}  // namespace

std::vector<TrueCamera> ReadTrueCameras(const std::filesystem::path& path) {
  const nlohmann::json json = ReadJson(path);
  const CheckedJson frames = CheckedJson(json, path).Field("frames");
  std::vector<TrueCamera> cameras;
  for (size_t i = 0; i < frames.Size(); ++i) {
    const CheckedJson frame = frames.Item(i);
    cameras.push_back({frame.Field("file").Text(), ReadPose(frame.Field("cam_from_world"))});
  }
  return cameras;
}

Similarity3 FitSimilarity(std::span<const glm::dvec3> from, std::span<const glm::dvec3> to) {
  if (from.size() != to.size() || from.size() < 3) {
    throw DataError(fmt::format("an alignment needs 3 or more pairs of points, got {} and {}",
                                from.size(), to.size()));
  }
  const Points source = AsColumns(from), target = AsColumns(to);
  CheckSpread(source, "reconstructed cameras");
  CheckSpread(target, "true cameras");
  const Eigen::Matrix4d fit = Eigen::umeyama(source, target, true);
  Similarity3 to_from_from;
  to_from_from.scale = std::cbrt(fit.topLeftCorner<3, 3>().determinant());
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) to_from_from.rotation[c][r] = fit(r, c) / to_from_from.scale;
    to_from_from.translation[r] = fit(r, 3);
  }
  return to_from_from;
}

Alignment AlignByCameras(const Scene& scene, std::span<const TrueCamera> cameras) {
  Alignment alignment;
  std::vector<glm::dvec3> centers_in_input, centers_in_truth;
  std::vector<const TrueCamera*> camera_of_match;
  std::vector<const View*> view_of_match;
  for (const View& view : scene.views) {
    const TrueCamera* camera = FindCamera(view, cameras);
    if (!camera) {
      alignment.unmatched.push_back(view.name);
      continue;
    }
    centers_in_input.push_back(scene.input_from_world * view.cam_from_world.Inverse().translation);
    centers_in_truth.push_back(camera->cam_from_truth.Inverse().translation);
    view_of_match.push_back(&view);
    camera_of_match.push_back(camera);
  }
  alignment.matched = centers_in_input.size();
  if (alignment.matched < 3) {
    throw DataError(
        fmt::format("only {} of {} views have a true camera with the same image name ({} true "
                    "cameras); at least 3 are required",
                    alignment.matched, scene.views.size(), cameras.size()));
  }
  alignment.truth_from_input = FitSimilarity(centers_in_input, centers_in_truth);

  const Similarity3 truth_from_world = alignment.truth_from_input * scene.input_from_world;
  glm::dvec3 mean(0.0);
  for (const glm::dvec3& center : centers_in_truth) mean += center / double(alignment.matched);
  for (size_t i = 0; i < alignment.matched; ++i) {
    const double distance =
        glm::length(alignment.truth_from_input * centers_in_input[i] - centers_in_truth[i]);
    alignment.center_rms += distance * distance;
    alignment.center_max = std::max(alignment.center_max, distance);
    const glm::dvec3 offset = centers_in_truth[i] - mean;
    alignment.center_spread += glm::dot(offset, offset);
    const double angle =
        AngleDegrees(camera_of_match[i]->cam_from_truth.rotation * truth_from_world.rotation,
                     view_of_match[i]->cam_from_world.rotation);
    alignment.rotation_mean_deg += angle / double(alignment.matched);
    alignment.rotation_max_deg = std::max(alignment.rotation_max_deg, angle);
  }
  alignment.center_rms = std::sqrt(alignment.center_rms / double(alignment.matched));
  alignment.center_spread = std::sqrt(alignment.center_spread / double(alignment.matched));
  return alignment;
}

}  // namespace tetrec
