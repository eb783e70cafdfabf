// The quality that COLMAP's model must have.
#include "sfm/model_quality.h"

#include "core/error.h"
#include "core/short_list.h"
#include "sfm/options.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace tetrec {
namespace {

constexpr double kMinRegisteredShare = 0.8;
constexpr size_t kMinPoints = 100;
// Proportionally more for photos larger than kErrorSize_px, but not so much that nothing could
// exceed it: COLMAP's mapper keeps no point whose error is above 4 px, so that errors of any size
// up to that have a mean of 2.7 px.
constexpr double kMaxMeanError_px = 1.5, kErrorSize_px = 1600, kLargestLimit_px = 2.5;
constexpr double kMinTrackLength = 2.5;

}  // namespace

std::vector<std::string> UnregisteredPhotos(const ColmapModel& model,
                                            const std::vector<std::string>& photo_names) {
  std::set<std::string> registered;
  for (const auto& [id, image] : model.images) registered.insert(image.name);
  std::vector<std::string> missing;
  for (const std::string& name : photo_names) {
    if (!registered.contains(name)) missing.push_back(name);
  }
  return missing;
}

bool HasEnoughPhotos(const ColmapModel& model, size_t photos) {
  return double(model.images.size()) >= kMinRegisteredShare * double(photos);
}

ModelQuality JudgeModel(const ColmapModel& model, const std::vector<std::string>& photo_names) {
  ModelQuality quality{model.images.size(), photo_names.size(), model.points.size(),
                       MeanReprojectionError_px(model), MeanTrackLength(model)};
  const std::vector<std::string> missing = UnregisteredPhotos(model, photo_names);
  if (!HasEnoughPhotos(model, photo_names.size())) {
    throw DataError(fmt::format(
        "only {} of {} photos could be registered ({:.0f} % are needed); not registered: {}; add "
        "photos between these and the others, or remove them",
        quality.registered, quality.photos, 100 * kMinRegisteredShare, ShortList(missing)));
  }
  if (quality.points < kMinPoints) {
    throw DataError(fmt::format(
        "only {} points were found, {} are needed; take more photos, with more overlap, of "
        "surfaces with texture",
        quality.points, kMinPoints));
  }
  double longest = 0;
  for (const auto& [id, camera] : model.cameras)
    longest = std::max(longest, double(std::max(camera.width, camera.height)));
  const double max_error_px =
      std::min(kLargestLimit_px, kMaxMeanError_px * std::max(1.0, longest / kErrorSize_px));
  if (quality.mean_error_px > max_error_px) {
    throw DataError(fmt::format(
        "the mean reprojection error is {:.2f} px; expected at most {:.2f}; if zoom or camera were "
        "changed between the photos, try camera sharing {}",
        quality.mean_error_px, max_error_px, Name(CameraSharing::kPerImage)));
  }
  if (quality.mean_track_length < kMinTrackLength) {
    throw DataError(fmt::format(
        "a point is seen in {:.2f} photos on average, {} are needed; take photos with more "
        "overlap",
        quality.mean_track_length, kMinTrackLength));
  }
  return quality;
}

}  // namespace tetrec
