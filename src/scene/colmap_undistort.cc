// Lens distortion of COLMAP's camera models, and pictures resampled to a pinhole camera.
#include "scene/colmap_undistort.h"

#include "core/error.h"
#include "scene/colmap_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <numbers>
#include <optional>

namespace tetrec {
namespace {

// One set of parameters for all models. A direction (x, y, 1) is first bent (by fisheyes), then
// moved in the plane as in Brown, "Decentering distortion of lenses", 1966: by a radial factor,
// tangential terms and a thin prism.
struct Lens {
  enum class Bend { kNone, kAngle, kFov, kDivision, kUnified };
  double fx = 0, fy = 0, cx = 0, cy = 0;
  Bend bend = Bend::kNone;
  double omega = 0;                    // of kFov [rad]
  double division = 0;                 // of kDivision
  double alpha = 0, beta = 1;          // of kUnified
  double over[6] = {}, under[3] = {};  // the radial factor's coefficients of r^2, r^4, ...
  double p1 = 0, p2 = 0;
  glm::dvec2 prism_2{0.0}, prism_4{0.0};  // of r^2 and r^4
  // Whether the tangential and prism terms go by the place that the radial factor gave, not by the
  // one before it.
  bool in_turn = false;
};

// Parameters as COLMAP's documentation of its camera models orders them.
Lens LensOf(const ColmapCamera& camera) {
  const std::vector<double>& p = camera.params;
  const auto one_focal = [&](Lens::Bend bend, double k1, double k2) {
    return Lens{.fx = p[0], .fy = p[0], .cx = p[1], .cy = p[2], .bend = bend, .over = {k1, k2}};
  };
  Lens lens;
  if (p.size() >= 4) lens = {.fx = p[0], .fy = p[1], .cx = p[2], .cy = p[3]};
  const auto set_over = [&](std::initializer_list<double> coefficients) {
    std::copy(coefficients.begin(), coefficients.end(), lens.over);
  };
  switch (camera.model) {
    case kColmapSimplePinhole:
      return one_focal(Lens::Bend::kNone, 0, 0);
    case kColmapPinhole:
      return lens;
    case kColmapSimpleRadial:
      return one_focal(Lens::Bend::kNone, p[3], 0);
    case kColmapRadial:
      return one_focal(Lens::Bend::kNone, p[3], p[4]);
    case kColmapSimpleRadialFisheye:
      return one_focal(Lens::Bend::kAngle, p[3], 0);
    case kColmapRadialFisheye:
      return one_focal(Lens::Bend::kAngle, p[3], p[4]);
    case kColmapOpenCv:
      set_over({p[4], p[5]});
      lens.p1 = p[6], lens.p2 = p[7];
      return lens;
    case kColmapFullOpenCv:
      set_over({p[4], p[5], p[8]});
      lens.p1 = p[6], lens.p2 = p[7];
      std::copy_n(&p[9], 3, lens.under);
      return lens;
    case kColmapOpenCvFisheye:
      lens.bend = Lens::Bend::kAngle;
      set_over({p[4], p[5], p[6], p[7]});
      return lens;
    case kColmapFov:
      lens.bend = Lens::Bend::kFov;
      lens.omega = p[4];
      return lens;
    case kColmapThinPrismFisheye:
      lens.bend = Lens::Bend::kAngle;
      set_over({p[4], p[5], p[8], p[9]});
      lens.p1 = p[6], lens.p2 = p[7];
      lens.prism_2 = {p[10], p[11]};
      return lens;
    case kColmapRadTanThinPrismFisheye:
      lens.bend = Lens::Bend::kAngle;
      set_over({p[4], p[5], p[6], p[7], p[8], p[9]});
      lens.p2 = p[10], lens.p1 = p[11];  // in this order; the others have them the other way round
      lens.prism_2 = {p[12], p[14]}, lens.prism_4 = {p[13], p[15]};
      lens.in_turn = true;
      return lens;
    case kColmapSimpleDivision:
      lens = one_focal(Lens::Bend::kDivision, 0, 0);
      lens.division = p[3];
      return lens;
    case kColmapDivision:
      lens.bend = Lens::Bend::kDivision;
      lens.division = p[4];
      return lens;
    case kColmapSimpleFisheye:
      return one_focal(Lens::Bend::kAngle, 0, 0);
    case kColmapFisheye:
      lens.bend = Lens::Bend::kAngle;
      return lens;
    case kColmapEucm:
      lens.bend = Lens::Bend::kUnified;
      lens.alpha = p[4], lens.beta = p[5];
      return lens;
    default:
      throw DataError(internal::ComplaintOnLens(fmt::to_string(camera.model)));
  }
}

// What bending makes of the distance r from the axis in the plane z = 1. kAngle: the angle from the
// axis (equidistant fisheye; Kannala and Brandt 2006). kFov: Devernay and Faugeras, "Straight lines
// have to be straight", 2001. kDivision: what r = b / (1 + k b^2) comes from (Fitzgibbon 2001);
// NaN where nothing does. kUnified: Khomutenko, Garcia and Martinet, "An enhanced unified camera
// model", 2016, equation 12.
double BentRadius(const Lens& lens, double r) {
  switch (lens.bend) {
    case Lens::Bend::kNone:
      return r;
    case Lens::Bend::kAngle:
      return std::atan(r);
    case Lens::Bend::kFov:
      return lens.omega == 0 ? r : std::atan(2 * r * std::tan(0.5 * lens.omega)) / lens.omega;
    case Lens::Bend::kDivision:
      return 2 * r / (1 + std::sqrt(1 - 4 * lens.division * r * r));
    case Lens::Bend::kUnified:
      return r / (lens.alpha * std::sqrt(lens.beta * r * r + 1) + 1 - lens.alpha);
  }
  throw BugError("unknown bend");
}

std::optional<double> TangentOf(double angle) {
  if (!(angle < std::numbers::pi / 2)) return std::nullopt;
  return std::tan(angle);
}

// r = bent / depth
std::optional<double> AtDepth(double bent, double depth) {
  if (!(depth > 0)) return std::nullopt;
  return bent / depth;
}

// Its inverse; none where the angle is 90 degrees or more, or (of kDivision) nothing leads there.
std::optional<double> UnbentRadius(const Lens& lens, double bent) {
  switch (lens.bend) {
    case Lens::Bend::kNone:
      return bent;
    case Lens::Bend::kAngle:
      return TangentOf(bent);
    case Lens::Bend::kFov: {
      if (lens.omega == 0) return bent;
      const std::optional<double> tangent = TangentOf(bent * std::abs(lens.omega));
      if (!tangent) return std::nullopt;
      return *tangent / (2 * std::tan(0.5 * std::abs(lens.omega)));
    }
    case Lens::Bend::kDivision: {
      const double k = lens.division * bent * bent;
      return k < 1 ? AtDepth(bent, 1 + k) : std::nullopt;  // r falls again beyond k b^2 = 1
    }
    case Lens::Bend::kUnified: {
      const double a = lens.alpha, bb = lens.beta * bent * bent;
      return AtDepth(bent, (1 - a * a * bb) / (a * std::sqrt(1 - (2 * a - 1) * bb) + 1 - a));
    }
  }
  throw BugError("unknown bend");
}

glm::dvec2 Bent(const Lens& lens, const glm::dvec2& direction) {
  if (lens.bend == Lens::Bend::kNone) return direction;
  const double r = glm::length(direction);
  // On the axis the factor tends to the derivative; r this small has no further digits to lose.
  constexpr double kTiny = 1e-9;
  return direction * (r > kTiny ? BentRadius(lens, r) / r : BentRadius(lens, kTiny) / kTiny);
}

std::optional<glm::dvec2> Unbent(const Lens& lens, const glm::dvec2& bent) {
  const double r = glm::length(bent);
  constexpr double kTiny = 1e-9;
  const std::optional<double> unbent = UnbentRadius(lens, std::max(r, kTiny));
  if (!unbent) return std::nullopt;
  return bent * (*unbent / std::max(r, kTiny));
}

// The radial factor (1 + k1 r^2 + ...) / (1 + k4 r^2 + ...) and its derivative by r^2.
struct Radial {
  double factor, slope;
};

Radial RadialAt(const Lens& lens, double rr) {
  const double(&k)[6] = lens.over, (&d)[3] = lens.under;
  double over = 0, over_slope = 0;  // by Horner's rule
  for (int i = 5; i >= 0; --i) {
    over = rr * (over + k[i]);
    over_slope = rr * over_slope + (i + 1) * k[i];
  }
  over += 1;
  const double under = 1 + rr * (d[0] + rr * (d[1] + rr * d[2]));
  const double under_slope = d[0] + rr * (2 * d[1] + rr * 3 * d[2]);
  return {over / under, (over_slope - over / under * under_slope) / under};
}

// x: 2 p1 x y + p2 (r^2 + 2 x^2) + prism; y alike with p1 and p2 exchanged.
glm::dvec2 SideShift(const Lens& lens, const glm::dvec2& q) {
  const double xy = q.x * q.y, rr = glm::dot(q, q);
  return glm::dvec2(2 * lens.p1 * xy + lens.p2 * (rr + 2 * q.x * q.x),
                    2 * lens.p2 * xy + lens.p1 * (rr + 2 * q.y * q.y)) +
         rr * (lens.prism_2 + rr * lens.prism_4);
}

// Columns are the derivatives by x and by y.
glm::dmat2 SideShiftJacobian(const Lens& lens, const glm::dvec2& q) {
  const double mixed = 2 * (lens.p1 * q.x + lens.p2 * q.y);
  const glm::dvec2 prism = 2.0 * (lens.prism_2 + 2 * glm::dot(q, q) * lens.prism_4);
  return glm::dmat2(2 * lens.p1 * q.y + 6 * lens.p2 * q.x, mixed, mixed,
                    2 * lens.p2 * q.x + 6 * lens.p1 * q.y) +
         glm::outerProduct(prism, q);
}

glm::dvec2 Moved(const Lens& lens, const glm::dvec2& b) {
  const glm::dvec2 scaled = b * RadialAt(lens, glm::dot(b, b)).factor;
  return scaled + SideShift(lens, lens.in_turn ? scaled : b);
}

glm::dmat2 MovedJacobian(const Lens& lens, const glm::dvec2& b) {
  const auto [factor, slope] = RadialAt(lens, glm::dot(b, b));
  const glm::dmat2 scaling = glm::dmat2(factor) + 2 * slope * glm::outerProduct(b, b);
  if (!lens.in_turn) return scaling + SideShiftJacobian(lens, b);
  return scaling + SideShiftJacobian(lens, b * factor) * scaling;
}

// Where a direction moves backwards as it goes on, along or, mirrored, across the radius. (Where it
// does both the determinant is positive again.)
bool IsFolded(const Lens& lens, const glm::dvec2& b) {
  const glm::dmat2 jacobian = MovedJacobian(lens, b);
  return !(glm::determinant(jacobian) > 0) || !(jacobian[0][0] + jacobian[1][1] > 0);
}

// Newton's iteration from `target` inwards, its steps halved where they lead to a place that is
// folded over or no better. None where it does not get there.
std::optional<glm::dvec2> Unmoved(const Lens& lens, const glm::dvec2& target) {
  constexpr int kMaxSteps = 50, kMaxHalvings = 40;
  constexpr double kTolerance = 1e-10;  // of the focal length: 1e-6 pixels of a large photo
  const auto error_at = [&](const glm::dvec2& b) { return glm::length(Moved(lens, b) - target); };
  const auto is_folded = [&](const glm::dvec2& b) { return IsFolded(lens, b); };
  glm::dvec2 b = target;
  for (int i = 0; i < kMaxHalvings && is_folded(b); ++i) b *= 0.5;
  double error = error_at(b);
  for (int i = 0; i < kMaxSteps; ++i) {
    if (is_folded(b)) return std::nullopt;
    if (error < kTolerance) return b;
    glm::dvec2 step = glm::inverse(MovedJacobian(lens, b)) * (target - Moved(lens, b));
    int halvings = 0;
    while (is_folded(b + step) || !(error_at(b + step) < error)) {
      if (++halvings > kMaxHalvings) return std::nullopt;
      step *= 0.5;
    }
    b += step;
    error = error_at(b);
  }
  return std::nullopt;
}

glm::dvec2 DistortedPixel(const Lens& lens, const glm::dvec2& direction) {
  const glm::dvec2 d = Moved(lens, Bent(lens, direction));
  return {lens.fx * d.x + lens.cx, lens.fy * d.y + lens.cy};
}

[[noreturn]] void FailInverse(const glm::dvec2& pixel, const char* why) {
  throw DataError(fmt::format("the lens distortion cannot be undone at pixel ({:.0f}, {:.0f}), {}",
                              pixel.x, pixel.y, why));
}

constexpr const char* kFolds = "where the lens model folds over";

glm::dvec2 MovedOfPixel(const Lens& lens, const glm::dvec2& pixel) {
  return {(pixel.x - lens.cx) / lens.fx, (pixel.y - lens.cy) / lens.fy};
}

// A box of directions that the photo covers: the tightest of each border's undistorted points.
struct Window {
  glm::dvec2 min, max;
  bool is_cut = false;                  // of a fisheye that sees more
  std::optional<glm::dvec2> folded_at;  // a pixel of the border that no direction leads to
};

const double kWidest = std::tan(std::numbers::pi / 3);  // 60 degrees

// Where a fisheye's border looks, along axis 0 (x) or 1 (y): at most `widest`, also where that is
// behind the plane or beyond where the lens model folds over.
double BorderDirection(const Lens& lens, const glm::dvec2& pixel, int axis, double widest,
                       Window& window) {
  const glm::dvec2 moved = MovedOfPixel(lens, pixel);
  const std::optional<glm::dvec2> bent = Unmoved(lens, moved);
  if (!bent && !window.folded_at) window.folded_at = pixel;
  if (lens.bend == Lens::Bend::kNone) return bent ? (*bent)[axis] : 0;
  const std::optional<glm::dvec2> direction = bent ? Unbent(lens, *bent) : std::nullopt;
  if (!direction && !window.folded_at) window.folded_at = pixel;
  if (!direction) return std::copysign(widest, moved[axis]);
  return std::clamp((*direction)[axis], -widest, widest);
}

Window WindowUpTo(const ColmapCamera& camera, const Lens& lens, double widest) {
  const auto width = double(camera.width), height = double(camera.height);
  Window window{glm::dvec2(-1e9), glm::dvec2(1e9), false, std::nullopt};
  constexpr int kSteps = 256;
  for (int i = 0; i <= kSteps; ++i) {
    const double x = width * i / kSteps, y = height * i / kSteps;
    window.min.x = std::max(window.min.x, BorderDirection(lens, {0, y}, 0, widest, window));
    window.max.x = std::min(window.max.x, BorderDirection(lens, {width, y}, 0, widest, window));
    window.min.y = std::max(window.min.y, BorderDirection(lens, {x, 0}, 1, widest, window));
    window.max.y = std::min(window.max.y, BorderDirection(lens, {x, height}, 1, widest, window));
  }
  window.is_cut = lens.bend != Lens::Bend::kNone &&
                  (glm::any(glm::lessThanEqual(window.min, glm::dvec2(-widest))) ||
                   glm::any(glm::greaterThanEqual(window.max, glm::dvec2(widest))));
  return window;
}

// Whether the lens model folds over somewhere in the window.
bool Folds(const Lens& lens, const Window& window) {
  constexpr int kSteps = 64;
  for (int j = 0; j <= kSteps; ++j) {
    for (int i = 0; i <= kSteps; ++i) {
      const glm::dvec2 share(double(i) / kSteps, double(j) / kSteps);
      if (IsFolded(lens, Bent(lens, glm::mix(window.min, window.max, share)))) return true;
    }
  }
  return false;
}

// The corners of the window look farther to the side than its borders: where the model folds over
// between, those corners end at kWidest.
Window CoveredWindow(const ColmapCamera& camera) {
  const Lens lens = LensOf(camera);
  Window window = WindowUpTo(camera, lens, kWidest);
  const glm::dvec2 bad_pixel = window.folded_at.value_or(glm::dvec2(0));
  if (lens.bend == Lens::Bend::kNone) {
    if (window.folded_at) FailInverse(bad_pixel, kFolds);
    return window;
  }
  if (!Folds(lens, window)) return window;
  window = WindowUpTo(camera, lens, kWidest / std::numbers::sqrt2);
  if (Folds(lens, window)) FailInverse(bad_pixel, kFolds);
  return window;
}

// Bilinear sample; beyond the border the border's pixels go on. `pixel` from the picture's corner.
// With alpha the colours are weighted by it.
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

// Pixels of the photo at the corners of the target's pixels, row by row. Inside a target pixel they
// are interpolated bilinearly: over so little the lens bends by less than a thousandth of a pixel.
std::vector<glm::vec2> PhotoPixelsOfCorners(const Lens& lens, const Camera& to) {
  std::vector<glm::vec2> corners;
  corners.reserve(size_t(to.width + 1) * size_t(to.height + 1));
  for (int y = 0; y <= to.height; ++y) {
    for (int x = 0; x <= to.width; ++x) {
      const glm::dvec3 direction = to.CamFromImage(glm::dvec2(x, y));
      const glm::dvec2 pixel = DistortedPixel(lens, {direction.x, direction.y});
      constexpr double kFarthest_px = 1e7;
      if (!(std::max(std::abs(pixel.x), std::abs(pixel.y)) < kFarthest_px)) {
        throw DataError(
            fmt::format("the lens has no pixel for the direction ({:.3g}, {:.3g}, 1), which its "
                        "picture covers; its distortion parameters are wrong",
                        direction.x, direction.y));
      }
      corners.emplace_back(pixel);
    }
  }
  return corners;
}

// So many samples a side of a target pixel that they lie at most a pixel of the photo apart: then
// bilinear samples weigh all of the photo's pixels alike. What lies outside the photo needs none of
// its own.
int SamplesASide(const Image& photo, const glm::vec2 (&corners)[4]) {
  glm::vec2 inside[4];
  for (int i = 0; i < 4; ++i) {
    inside[i] = glm::clamp(corners[i], glm::vec2(-1), glm::vec2(photo.width + 1, photo.height + 1));
  }
  const float longest =
      std::max(std::max(glm::distance(inside[0], inside[1]), glm::distance(inside[2], inside[3])),
               std::max(glm::distance(inside[0], inside[2]), glm::distance(inside[1], inside[3])));
  // A pixel as large as the photo's, but for rounding and the bend of the lens, needs no more.
  return std::max(1, int(std::ceil(longest - 0.05f)));
}

template <int kChannels>
Image Resampled(const Image& photo, const Camera& to, const std::vector<glm::vec2>& grid) {
  Image picture = MakeImage(to.width, to.height, kChannels);
  for (int y = 0; y < to.height; ++y) {
    for (int x = 0; x < to.width; ++x) {
      const glm::vec2* above = &grid[size_t(y) * size_t(to.width + 1) + size_t(x)];
      const glm::vec2* below = above + to.width + 1;
      const glm::vec2 corners[4] = {above[0], above[1], below[0], below[1]};
      const int samples = SamplesASide(photo, corners);
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
      uint8_t* pixel = picture.At(x, y);
      if (kChannels == 4) pixel[3] = ToByte(sum[3] / float(samples * samples));
      if (kChannels == 4 && pixel[3] == 0) continue;
      for (int k = 0; k < 3; ++k) pixel[k] = ToByte(sum[k] / sum[3]);
    }
  }
  return picture;
}

}  // namespace

ColmapCamera ScaledLens(const ColmapCamera& camera, int width, int height) {
  ColmapCamera scaled = camera;
  std::vector<double>& p = scaled.params;
  const auto two_focals = [&](ColmapLens model, size_t params) {
    scaled.model = model;
    p.insert(p.begin(), p[0]);
    p.resize(params, 0.0);
  };
  if (camera.model == kColmapSimplePinhole) two_focals(kColmapPinhole, 4);
  if (camera.model == kColmapSimpleRadial || camera.model == kColmapRadial) {
    two_focals(kColmapOpenCv, 8);
  }
  if (camera.model == kColmapSimpleRadialFisheye || camera.model == kColmapRadialFisheye) {
    two_focals(kColmapOpenCvFisheye, 8);
  }
  if (camera.model == kColmapSimpleDivision) two_focals(kColmapDivision, 5);
  if (camera.model == kColmapSimpleFisheye) two_focals(kColmapFisheye, 4);
  const double x = width / double(camera.width), y = height / double(camera.height);
  p[0] *= x, p[1] *= y, p[2] *= x, p[3] *= y;
  scaled.width = uint64_t(width);
  scaled.height = uint64_t(height);
  return scaled;
}

glm::dvec2 DistortedImageFromCam(const ColmapCamera& camera, const glm::dvec2& direction) {
  return DistortedPixel(LensOf(camera), direction);
}

glm::dvec2 CamFromDistortedImage(const ColmapCamera& camera, const glm::dvec2& pixel) {
  const Lens lens = LensOf(camera);
  const std::optional<glm::dvec2> bent = Unmoved(lens, MovedOfPixel(lens, pixel));
  if (!bent) FailInverse(pixel, kFolds);
  const std::optional<glm::dvec2> direction = Unbent(lens, *bent);
  if (!direction) {
    const bool folds = lens.bend == Lens::Bend::kDivision && lens.division > 0;
    FailInverse(pixel, folds ? kFolds : "which looks 90 degrees or more off the axis");
  }
  return *direction;
}

bool IsTooWideForPlane(const ColmapCamera& camera) { return CoveredWindow(camera).is_cut; }

Camera UndistortedCamera(const ColmapCamera& camera, int max_size) {
  const Lens lens = LensOf(camera);
  if (!(lens.fx > 0) || !(lens.fy > 0)) {
    throw DataError(fmt::format(
        "a camera has the focal lengths {} and {} px; both must be positive", lens.fx, lens.fy));
  }
  Window window = CoveredWindow(camera);
  glm::dvec2 size = (window.max - window.min) * glm::dvec2(lens.fx, lens.fy);
  if (!(size.x >= 1 && size.y >= 1)) {
    throw DataError("the lens distortion leaves nothing of the picture");
  }
  // Keep the photo's format, so that all working pictures of one camera type have the usual sizes.
  const double format = double(camera.width) / double(camera.height);
  const glm::dvec2 kept = glm::min(size, glm::dvec2(size.y * format, size.x / format));
  const glm::dvec2 cut = 0.5 * (size - kept) / glm::dvec2(lens.fx, lens.fy);
  window.min += cut;
  window.max -= cut;
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
  const std::vector<glm::vec2> grid = PhotoPixelsOfCorners(lens, to);
  return photo.channels == 4 ? Resampled<4>(photo, to, grid) : Resampled<3>(photo, to, grid);
}

void FailOnLens(const std::filesystem::path& picture, const ColmapCamera& camera,
                const std::string& complaint, const std::string& advice) {
  const std::span<const internal::ColmapLensKind> kinds = internal::ColmapLensKinds();
  const bool known = camera.model >= 0 && size_t(camera.model) < kinds.size();
  const std::string model = known ? kinds[size_t(camera.model)].name : fmt::to_string(camera.model);
  throw DataError(fmt::format("{} (lens {}): {}{}{}", picture.string(), model, complaint,
                              advice.empty() ? "" : "; ", advice));
}

}  // namespace tetrec
