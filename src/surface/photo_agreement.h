// How well photos agree on a small patch of a surface.
#pragma once

#include "surface/texture_photos.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace tetrec {

// A flat square of (2 kPatchRadius + 1)^2 samples in the world.
inline constexpr int kPatchRadius = 2;
struct SurfacePatch {
  glm::dvec3 center, across, up;  // from one sample to the next
};

// The luma of photos, by which patches are compared.
class PhotoPatches {
 public:
  // The photos must outlive this.
  explicit PhotoPatches(std::span<const TexturePhoto> photos);

  // The mean over all pairs of `photos` of the zero-mean normalised cross-correlation of what they
  // show of the patch, from -1 to 1; no gain and offset of a photo changes it, and noise without
  // texture correlates little. Photos in which a part of the patch is out of the image do not
  // count; 0 if fewer than two do.
  double Agreement(const SurfacePatch& patch, std::span<const uint32_t> photos) const;

 private:
  std::span<const TexturePhoto> photos_;
  std::vector<std::vector<float>> luma_;  // by photo (height x width), in [0, 1]
};

}  // namespace tetrec
