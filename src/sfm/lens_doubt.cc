// Oblong pixels, and lenses that cannot be undone.
#include "sfm/lens_doubt.h"

#include "core/error.h"
#include "geometry/lens.h"
#include "geometry/undistorted_camera.h"
#include "sfm/model_quality.h"
#include "sfm/retry.h"

#include <fmt/format.h>

#include <cmath>

namespace tetrec {

std::optional<LensDoubt> DoubtOf(const ColmapModel& model, size_t photos, int max_size) {
  // Logarithms. Photos that only a grossly stretched lens registers are in wrong places.
  constexpr double kLargestStretch = 0.01, kGrossStretch = 0.1, kLeastPhotosOfGross = 0.8;
  if (!HasEnoughPhotos(model, photos)) {
    return LensDoubt{
        .reason = fmt::format("only {} of {} photos are registered", model.images.size(), photos),
        .has_too_few_photos = true};
  }
  try {
    for (const auto& [id, camera] : model.cameras) UndistortedCamera(camera, max_size);
  } catch (const DataError& error) {
    return LensDoubt{error.what(), true};
  }
  double stretched = 1;  // the width of a pixel that is farthest from its height
  for (const auto& [id, camera] : model.cameras) {
    if (FocalLengths(camera.model) == 1) continue;
    const double width = camera.params[1] / camera.params[0];
    if (std::abs(std::log(width)) > std::abs(std::log(stretched))) stretched = width;
  }
  const double stretch = std::abs(std::log(stretched));
  if (!(stretch > kLargestStretch)) return std::nullopt;
  return LensDoubt{fmt::format("a pixel would be {:.3f} times as wide as it is high", stretched),
                   false, stretch > kGrossStretch ? kLeastPhotosOfGross : 1.0};
}

bool Replaces(const ColmapModel& simpler, const ColmapModel& model, const LensDoubt& doubt,
              size_t photos, int max_size) {
  constexpr double kLeastPoints = 0.5, kErrorGrowth = 1.2;
  if (doubt.has_too_few_photos) return IsBetterModel(model, simpler);
  if (!HasEnoughPhotos(simpler, photos)) return false;
  if (doubt.is_unusable) return true;
  const std::optional<LensDoubt> other_doubt = DoubtOf(simpler, photos, max_size);
  if (other_doubt && other_doubt->is_unusable) return false;
  return double(simpler.images.size()) >= doubt.least_photos * double(model.images.size()) &&
         double(simpler.points.size()) >= kLeastPoints * double(model.points.size()) &&
         MeanReprojectionError_px(simpler) <= kErrorGrowth * MeanReprojectionError_px(model);
}

}  // namespace tetrec
