// Normalised cross-correlation of patches in several photos.
#include "surface/photo_agreement.h"

#include "core/parallel.h"
#include "image/luma.h"

#include <array>
#include <cmath>

namespace tetrec {
namespace {

constexpr int kSide = 2 * kPatchRadius + 1;
constexpr size_t kSamples = size_t(kSide) * size_t(kSide);

// Contrast of a patch that counts half [luma, root mean square]: noise of photos has about as much.
constexpr float kWeakContrast = 0.01f;

using Samples = std::array<float, kSamples>;

// Where a photo shows a patch, which is small enough for an affine map.
struct ImagePatch {
  glm::dvec2 center, across, up;
};

ImagePatch Project(const SurfacePatch& patch, const TexturePhoto& photo) {
  const auto pixel = [&](const glm::dvec3& point) {
    return photo.camera.ImageFromCam(photo.cam_from_world * point);
  };
  const glm::dvec2 center = pixel(patch.center);
  return {center, pixel(patch.center + patch.across) - center,
          pixel(patch.center + patch.up) - center};
}

// False if the patch reaches beyond the centres of the outer pixels.
bool IsInside(const ImagePatch& patch, const Camera& camera) {
  const glm::dvec2 reach = double(kPatchRadius) * (glm::abs(patch.across) + glm::abs(patch.up));
  const glm::dvec2 low = patch.center - reach, high = patch.center + reach;
  return low.x >= 0.5 && low.y >= 0.5 && high.x < camera.width - 0.5 &&
         high.y < camera.height - 0.5;
}

float Interpolate(const std::vector<float>& luma, int width, float x, float y) {
  const int left = int(x), top = int(y);
  const float u = x - float(left), v = y - float(top);
  const float* row = &luma[size_t(top) * size_t(width) + size_t(left)];
  const float* below = row + width;
  return (1 - v) * ((1 - u) * row[0] + u * row[1]) + v * ((1 - u) * below[0] + u * below[1]);
}

// Mean 0; of length 1 if the contrast is strong.
void Normalize(Samples& samples) {
  float sum = 0, squares = 0;
  for (const float value : samples) sum += value;
  const float mean = sum / float(kSamples);
  for (float& value : samples) {
    value -= mean;
    squares += value * value;
  }
  const float scale = 1 / std::sqrt(squares + float(kSamples) * kWeakContrast * kWeakContrast);
  for (float& value : samples) value *= scale;
}

Samples Take(const ImagePatch& patch, const std::vector<float>& luma, int width) {
  Samples samples;
  size_t next = 0;
  for (int j = -kPatchRadius; j <= kPatchRadius; ++j) {
    for (int i = -kPatchRadius; i <= kPatchRadius; ++i) {
      const glm::dvec2 pixel = patch.center + double(i) * patch.across + double(j) * patch.up - 0.5;
      samples[next++] = Interpolate(luma, width, float(pixel.x), float(pixel.y));
    }
  }
  Normalize(samples);
  return samples;
}

}  // namespace

PhotoPatches::PhotoPatches(std::span<const TexturePhoto> photos)
    : photos_(photos), luma_(photos.size()) {
  ParallelFor(photos.size(), 1, [&](size_t begin, size_t end) {
    for (size_t p = begin; p < end; ++p) {
      const Image& image = photos[p].image;
      for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) luma_[p].push_back(Luma(image.At(x, y)));
      }
    }
  });
}

double PhotoPatches::Agreement(const SurfacePatch& patch, std::span<const uint32_t> photos) const {
  // The square of a sum of vectors is the sum of their squares plus twice that of all pairs'
  // products.
  Samples sum{};
  float own = 0;
  int count = 0;
  for (const uint32_t p : photos) {
    const Camera& camera = photos_[p].camera;
    const ImagePatch in_image = Project(patch, photos_[p]);
    if (!IsInside(in_image, camera)) continue;
    const Samples samples = Take(in_image, luma_[p], camera.width);
    for (size_t i = 0; i < kSamples; ++i) {
      sum[i] += samples[i];
      own += samples[i] * samples[i];
    }
    ++count;
  }
  if (count < 2) return 0;
  float all = 0;
  for (const float value : sum) all += value * value;
  return double(all - own) / (double(count) * (count - 1));
}

}  // namespace tetrec
