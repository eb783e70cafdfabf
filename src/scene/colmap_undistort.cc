// Lens distortion of COLMAP's camera models, and pictures resampled to a pinhole camera.
#include "scene/colmap_undistort.h"

#include "core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tetrec {
namespace {

enum Model { kSimplePinhole = 0, kPinhole = 1, kSimpleRadial = 2, kRadial = 3, kOpenCv = 4 };

// One set of parameters for all models that can be undistorted.
struct Lens {
  double fx, fy, cx, cy;
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0;
};

Lens LensOf(const ColmapCamera& camera) {
  const std::vector<double>& p = camera.params;
  switch (camera.model) {
    case kSimplePinhole:
      return {p[0], p[0], p[1], p[2]};
    case kPinhole:
      return {p[0], p[1], p[2], p[3]};
    case kSimpleRadial:
      return {p[0], p[0], p[1], p[2], p[3]};
    case kRadial:
      return {p[0], p[0], p[1], p[2], p[3], p[4]};
    case kOpenCv:
      return {p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7]};
    default:
      break;
  }
  throw DataError(
      fmt::format("COLMAP's camera model {} cannot be undistorted; use OPENCV, RADIAL, "
                  "SIMPLE_RADIAL or PINHOLE",
                  camera.model));
}

// r^2 = x^2 + y^2; x' = x (1 + k1 r^2 + k2 r^4) + 2 p1 x y + p2 (r^2 + 2 x^2), y' alike (Brown
// 1966, as OpenCV orders the parameters).
glm::dvec2 Distort(const Lens& lens, const glm::dvec2& d) {
  const double xx = d.x * d.x, yy = d.y * d.y, xy = d.x * d.y, rr = xx + yy;
  const double radial = 1 + rr * (lens.k1 + rr * lens.k2);
  return {d.x * radial + 2 * lens.p1 * xy + lens.p2 * (rr + 2 * xx),
          d.y * radial + 2 * lens.p2 * xy + lens.p1 * (rr + 2 * yy)};
}

// d Distort / d direction; columns are the derivatives by x and by y.
glm::dmat2 DistortJacobian(const Lens& lens, const glm::dvec2& d) {
  const double rr = glm::dot(d, d), radial = 1 + rr * (lens.k1 + rr * lens.k2);
  const double slope = 2 * lens.k1 + 4 * lens.k2 * rr;  // (d radial / d x) / x
  const double mixed = slope * d.x * d.y + 2 * lens.p1 * d.x + 2 * lens.p2 * d.y;
  return {{radial + slope * d.x * d.x + 2 * lens.p1 * d.y + 6 * lens.p2 * d.x, mixed},
          {mixed, radial + slope * d.y * d.y + 2 * lens.p2 * d.x + 6 * lens.p1 * d.y}};
}

glm::dvec2 DistortedPixel(const Lens& lens, const glm::dvec2& direction) {
  const glm::dvec2 d = Distort(lens, direction);
  return {lens.fx * d.x + lens.cx, lens.fy * d.y + lens.cy};
}

// A box of directions that the photo covers: the tightest of each border's undistorted points.
struct Window {
  glm::dvec2 min, max;
};

Window CoveredWindow(const ColmapCamera& camera) {
  const auto width = double(camera.width), height = double(camera.height);
  Window window{glm::dvec2(-1e9), glm::dvec2(1e9)};
  constexpr int kSteps = 256;
  for (int i = 0; i <= kSteps; ++i) {
    const double x = width * i / kSteps, y = height * i / kSteps;
    window.min.x = std::max(window.min.x, CamFromDistortedImage(camera, {0, y}).x);
    window.max.x = std::min(window.max.x, CamFromDistortedImage(camera, {width, y}).x);
    window.min.y = std::max(window.min.y, CamFromDistortedImage(camera, {x, 0}).y);
    window.max.y = std::min(window.max.y, CamFromDistortedImage(camera, {x, height}).y);
  }
  return window;
}

// Bilinear sample; beyond the border the border's pixels go on. `pixel` from the picture's corner.
void AddSample(const Image& photo, const glm::dvec2& pixel, float (&sum)[4]) {
  const float x = std::clamp(float(pixel.x) - 0.5f, 0.0f, float(photo.width - 1));
  const float y = std::clamp(float(pixel.y) - 0.5f, 0.0f, float(photo.height - 1));
  const int x0 = std::min(int(x), std::max(photo.width - 2, 0)),
            y0 = std::min(int(y), std::max(photo.height - 2, 0));
  const int x1 = std::min(x0 + 1, photo.width - 1), y1 = std::min(y0 + 1, photo.height - 1);
  const float u = x - float(x0), v = y - float(y0);
  const uint8_t *a = photo.At(x0, y0), *b = photo.At(x1, y0), *c = photo.At(x0, y1),
                *d = photo.At(x1, y1);
  for (int k = 0; k < photo.channels; ++k) {
    sum[k] += (1 - v) * ((1 - u) * float(a[k]) + u * float(b[k])) +
              v * ((1 - u) * float(c[k]) + u * float(d[k]));
  }
}

}  // namespace

bool CanUndistort(const ColmapCamera& camera) {
  return camera.model >= kSimplePinhole && camera.model <= kOpenCv;
}

glm::dvec2 DistortedImageFromCam(const ColmapCamera& camera, const glm::dvec2& direction) {
  return DistortedPixel(LensOf(camera), direction);
}

glm::dvec2 CamFromDistortedImage(const ColmapCamera& camera, const glm::dvec2& pixel) {
  const Lens lens = LensOf(camera);
  const glm::dvec2 target{(pixel.x - lens.cx) / lens.fx, (pixel.y - lens.cy) / lens.fy};
  constexpr int kMaxIterations = 50;
  constexpr double kTolerance =
      1e-10;  // in units of the focal length: 1e-6 pixels of a large photo
  glm::dvec2 direction = target;
  for (int i = 0; i < kMaxIterations; ++i) {
    const glm::dvec2 error = Distort(lens, direction) - target;
    const glm::dmat2 jacobian = DistortJacobian(lens, direction);
    // Where the determinant is not positive the picture is folded over.
    if (!(glm::determinant(jacobian) > 0)) break;
    if (glm::dot(error, error) < kTolerance * kTolerance) return direction;
    direction -= glm::inverse(jacobian) * error;
  }
  throw DataError(
      fmt::format("the lens distortion that COLMAP found cannot be inverted at pixel ({:.0f}, "
                  "{:.0f}); try --camera-model SIMPLE_RADIAL",
                  pixel.x, pixel.y));
}

Camera UndistortedCamera(const ColmapCamera& camera, int max_size) {
  const Lens lens = LensOf(camera);
  if (!(lens.fx > 0) || !(lens.fy > 0)) {
    throw DataError(fmt::format(
        "COLMAP found the focal lengths {} and {} px; both must be positive", lens.fx, lens.fy));
  }
  Window window = CoveredWindow(camera);
  glm::dvec2 size = (window.max - window.min) * glm::dvec2(lens.fx, lens.fy);
  if (!(size.x >= 1 && size.y >= 1)) {
    throw DataError(
        "the lens distortion that COLMAP found leaves nothing of the picture; try --camera-model "
        "SIMPLE_RADIAL");
  }
  // Keep the photo's format, so that all working pictures of one camera type have the usual sizes.
  const double format = double(camera.width) / double(camera.height);
  const glm::dvec2 kept = glm::min(size, glm::dvec2(size.y * format, size.x / format));
  const glm::dvec2 cut = 0.5 * (size - kept) / glm::dvec2(lens.fx, lens.fy);
  window = {window.min + cut, window.max - cut};
  size = kept;

  // A barrel lens spreads the photo out: at its focal length there would be more pixels than taken.
  const double longer = std::max(size.x, size.y);
  const double most = std::min(double(max_size), double(std::max(camera.width, camera.height)));
  const double scale = std::min(1.0, most / longer);
  Camera to;
  to.width = std::max(1, int(std::lround(size.x * scale)));
  to.height = std::max(1, int(std::lround(size.y * scale)));
  // Rounded sizes: the whole window still fills the whole picture.
  to.fx = to.width / (window.max.x - window.min.x);
  to.fy = to.height / (window.max.y - window.min.y);
  to.cx = -window.min.x * to.fx;
  to.cy = -window.min.y * to.fy;
  return to;
}

Image Undistort(const Image& photo, const ColmapCamera& from, const Camera& to) {
  TETREC_CHECK(uint64_t(photo.width) == from.width && uint64_t(photo.height) == from.height,
               "the photo has another size than its camera");
  const Lens lens = LensOf(from);
  // Samples a side of each target pixel, so that no pixel of the photo is passed over.
  const int samples =
      std::max(1, int(std::ceil(std::max(lens.fx / to.fx, lens.fy / to.fy) - 1e-3))) * 2;
  Image picture{to.width, to.height, photo.channels, {}};
  picture.pixels.resize(size_t(to.width) * to.height * photo.channels);
  for (int y = 0; y < to.height; ++y) {
    for (int x = 0; x < to.width; ++x) {
      float sum[4] = {};
      for (int s = 0; s < samples * samples; ++s) {
        const glm::dvec2 offset{(s % samples + 0.5) / samples, (s / samples + 0.5) / samples};
        const glm::dvec3 direction = to.CamFromImage(glm::dvec2(x, y) + offset);
        AddSample(photo, DistortedPixel(lens, {direction.x, direction.y}), sum);
      }
      for (int k = 0; k < photo.channels; ++k) {
        picture.At(x, y)[k] =
            uint8_t(std::lround(std::clamp(sum[k] / float(samples * samples), 0.0f, 255.0f)));
      }
    }
  }
  return picture;
}

}  // namespace tetrec
