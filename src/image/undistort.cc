// Images resampled to a pinhole camera.
#include "image/undistort.h"

#include "core/error.h"
#include "geometry/lens_distortion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace tetrec {
namespace {

// Adds a bilinear sample at `pixel`, measured from the image's corner. Outside the image the border
// pixels are repeated. Alpha, if there is any, weights the colours.
template <int kChannels>
void AddSample(const Image& photo, const glm::vec2& pixel, float (&sum)[4]) {
  const float x = std::clamp(pixel.x - 0.5f, 0.0f, float(photo.width - 1));
  const float y = std::clamp(pixel.y - 0.5f, 0.0f, float(photo.height - 1));
  const int x0 = std::min(int(x), std::max(photo.width - 2, 0)),
            y0 = std::min(int(y), std::max(photo.height - 2, 0));
  const int x1 = std::min(x0 + 1, photo.width - 1), y1 = std::min(y0 + 1, photo.height - 1);
  const float u = x - float(x0), v = y - float(y0);
  const float weights[4] = {(1 - v) * (1 - u), (1 - v) * u, v * (1 - u), v * u};
  const uint8_t* corners[4] = {photo.At(x0, y0), photo.At(x1, y0), photo.At(x0, y1),
                               photo.At(x1, y1)};
  for (int i = 0; i < 4; ++i) {
    const float weight = kChannels == 4 ? weights[i] * float(corners[i][3]) : weights[i];
    for (int k = 0; k < 3; ++k) sum[k] += weight * float(corners[i][k]);
    sum[3] += weight;
  }
}

uint8_t ToByte(float value) { return uint8_t(std::clamp(value + 0.5f, 0.0f, 255.0f)); }

// Places in the photo [px] of the corners of the target's pixels, row by row. Inside a target pixel
// they are interpolated bilinearly: over this distance the lens bends by less than a thousandth of
// a pixel.
std::vector<glm::vec2> PhotoPixelsOfCorners(const LensTerms& terms, const Camera& to) {
  std::vector<glm::vec2> corners;
  corners.reserve(size_t(to.width + 1) * size_t(to.height + 1));
  for (int y = 0; y <= to.height; ++y) {
    for (int x = 0; x <= to.width; ++x) {
      const glm::dvec3 direction = to.CamFromImage(glm::dvec2(x, y));
      const glm::dvec2 pixel = DistortedPixel(terms, {direction.x, direction.y});
      constexpr double kFarthest_px = 1e7;
      if (!(std::max(std::abs(pixel.x), std::abs(pixel.y)) < kFarthest_px)) {
        throw DataError(
            fmt::format("the lens has no pixel for the direction ({:.3g}, {:.3g}, 1), which its "
                        "image covers; its distortion parameters are wrong",
                        direction.x, direction.y));
      }
      corners.emplace_back(pixel);
    }
  }
  return corners;
}

// Samples along each side of a target pixel, so many that they are at most one pixel of the photo
// apart: bilinear samples then weight all of the photo's pixels equally. Parts outside the photo do
// not count.
int SamplesPerSide(const Image& photo, const glm::vec2 (&corners)[4]) {
  glm::vec2 inside[4];
  for (int i = 0; i < 4; ++i) {
    inside[i] = glm::clamp(corners[i], glm::vec2(-1), glm::vec2(photo.width + 1, photo.height + 1));
  }
  const float longest =
      std::max(std::max(glm::distance(inside[0], inside[1]), glm::distance(inside[2], inside[3])),
               std::max(glm::distance(inside[0], inside[2]), glm::distance(inside[1], inside[3])));
  // One sample is enough for a pixel as large as the photo's, apart from rounding and the bend of
  // the lens.
  return std::max(1, int(std::ceil(longest - 0.05f)));
}

template <int kChannels>
Image Resampled(const Image& photo, const Camera& to, const std::vector<glm::vec2>& grid) {
  Image image = MakeImage(to.width, to.height, kChannels);
  for (int y = 0; y < to.height; ++y) {
    for (int x = 0; x < to.width; ++x) {
      const glm::vec2* above = &grid[size_t(y) * size_t(to.width + 1) + size_t(x)];
      const glm::vec2* below = above + to.width + 1;
      const glm::vec2 corners[4] = {above[0], above[1], below[0], below[1]};
      const int samples = SamplesPerSide(photo, corners);
      float sum[4] = {};
      for (int j = 0; j < samples; ++j) {
        const float v = (float(j) + 0.5f) / float(samples);
        const glm::vec2 left = glm::mix(corners[0], corners[2], v);
        const glm::vec2 right = glm::mix(corners[1], corners[3], v);
        for (int i = 0; i < samples; ++i) {
          AddSample<kChannels>(photo, glm::mix(left, right, (float(i) + 0.5f) / float(samples)),
                               sum);
        }
      }
      uint8_t* pixel = image.At(x, y);
      if (kChannels == 4) pixel[3] = ToByte(sum[3] / float(samples * samples));
      if (kChannels == 4 && pixel[3] == 0) continue;
      for (int k = 0; k < 3; ++k) pixel[k] = ToByte(sum[k] / sum[3]);
    }
  }
  return image;
}

}  // namespace

Image Undistort(const Image& photo, const Lens& from, const Camera& to) {
  TETREC_CHECK(uint64_t(photo.width) == from.width && uint64_t(photo.height) == from.height,
               "the photo and its lens differ in size");
  const LensTerms terms = LensTermsOf(from);
  const std::vector<glm::vec2> grid = PhotoPixelsOfCorners(terms, to);
  return photo.channels == 4 ? Resampled<4>(photo, to, grid) : Resampled<3>(photo, to, grid);
}

void FailOnLens(const std::filesystem::path& photo, const Lens& lens, const std::string& complaint,
                const std::string& advice) {
  throw DataError(fmt::format("{} (lens {}): {}{}{}", photo.string(), Name(lens.model), complaint,
                              advice.empty() ? "" : "; ", advice));
}

}  // namespace tetrec
