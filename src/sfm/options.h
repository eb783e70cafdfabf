// The options of structure from motion.
#pragma once

#include "colmap/pairs.h"
#include "core/words.h"
#include "geometry/bounds3.h"
#include "scene/split.h"

#include <array>
#include <optional>

namespace tetrec {

// Which photos share the parameters of one lens. kAuto: those of one size whose EXIF notes the same
// camera, focal length and digital zoom.
enum class CameraSharing { kAuto, kSingle, kPerFolder, kPerImage };
template <>
inline constexpr auto kWords<CameraSharing> =
    std::to_array<Word<CameraSharing>>({{CameraSharing::kAuto, "auto"},
                                        {CameraSharing::kSingle, "single"},
                                        {CameraSharing::kPerFolder, "per-folder"},
                                        {CameraSharing::kPerImage, "per-image"}});

// The lens model that COLMAP fits. kAuto: for each camera OPENCV, or SIMPLE_RADIAL if it took few
// photos; or a simpler one for all where the photos do not determine that (MapPhotos).
enum class SfmLens { kAuto, kOpenCv, kRadial, kSimpleRadial, kPinhole, kSimplePinhole };
template <>
inline constexpr auto kWords<SfmLens> =
    std::to_array<Word<SfmLens>>({{SfmLens::kAuto, "auto"},
                                  {SfmLens::kOpenCv, "OPENCV"},
                                  {SfmLens::kRadial, "RADIAL"},
                                  {SfmLens::kSimpleRadial, "SIMPLE_RADIAL"},
                                  {SfmLens::kPinhole, "PINHOLE"},
                                  {SfmLens::kSimplePinhole, "SIMPLE_PINHOLE"}});

struct SfmOptions {
  PairChoice matcher = PairChoice::kAuto;
  CameraSharing camera_sharing = CameraSharing::kAuto;
  SfmLens camera_model = SfmLens::kAuto;
  int frames = 80;          // at most so many of a video; all pairs of 80 photos are matched
  int max_features = 3072;  // features per photo, those of the largest scales
  // Where photos stay unregistered: further tries, each with more features for the photos
  // concerned; and if too few are registered still, one with milder demands of the mapper.
  int retries = 1;
  // Share of the photos that may be unreadable and are left out; with more, there is no scene.
  double max_unreadable = 0.25;
  // The subject's box, in the world of a scene that was made without it (that of its points.ply).
  std::optional<Bounds3> bounds_in_found_world;
  int max_size = 640;           // [px] longer side of the scene's images
  int holdout = kUsualHoldout;  // every N-th view is held out as test; 0: none
  // Every N-th of the views that are not held out is trained on, the others only help to find the
  // cameras and are left out of the scene; 1: all are trained on. For measuring how few photos
  // suffice, judged by the same held-out views.
  int train_every = 1;
  int seed = 0;  // random seed of COLMAP's mapper

  // Throws UsageError, which names the option and its value.
  void Check() const;
};

}  // namespace tetrec
