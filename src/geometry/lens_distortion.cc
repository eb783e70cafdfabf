// The formulas of lens distortion.
#include "geometry/lens_distortion.h"

#include "core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <numbers>

namespace tetrec {

LensTerms LensTermsOf(const Lens& lens) {
  const std::vector<double>& p = lens.params;
  const auto one_focal = [&](LensTerms::Bend bend, double k1, double k2) {
    return LensTerms{
        .fx = p[0], .fy = p[0], .cx = p[1], .cy = p[2], .bend = bend, .over = {k1, k2}};
  };
  LensTerms terms;
  if (p.size() >= 4) terms = {.fx = p[0], .fy = p[1], .cx = p[2], .cy = p[3]};
  const auto set_over = [&](std::initializer_list<double> coefficients) {
    std::copy(coefficients.begin(), coefficients.end(), terms.over);
  };
  switch (lens.model) {
    case LensModel::kSimplePinhole:
      return one_focal(LensTerms::Bend::kNone, 0, 0);
    case LensModel::kPinhole:
      return terms;
    case LensModel::kSimpleRadial:
      return one_focal(LensTerms::Bend::kNone, p[3], 0);
    case LensModel::kRadial:
      return one_focal(LensTerms::Bend::kNone, p[3], p[4]);
    case LensModel::kSimpleRadialFisheye:
      return one_focal(LensTerms::Bend::kAngle, p[3], 0);
    case LensModel::kRadialFisheye:
      return one_focal(LensTerms::Bend::kAngle, p[3], p[4]);
    case LensModel::kOpenCv:
      set_over({p[4], p[5]});
      terms.p1 = p[6], terms.p2 = p[7];
      return terms;
    case LensModel::kFullOpenCv:
      set_over({p[4], p[5], p[8]});
      terms.p1 = p[6], terms.p2 = p[7];
      std::copy_n(&p[9], 3, terms.under);
      return terms;
    case LensModel::kOpenCvFisheye:
      terms.bend = LensTerms::Bend::kAngle;
      set_over({p[4], p[5], p[6], p[7]});
      return terms;
    case LensModel::kFov:
      terms.bend = LensTerms::Bend::kFov;
      terms.omega = p[4];
      return terms;
    case LensModel::kThinPrismFisheye:
      terms.bend = LensTerms::Bend::kAngle;
      set_over({p[4], p[5], p[8], p[9]});
      terms.p1 = p[6], terms.p2 = p[7];
      terms.prism_2 = {p[10], p[11]};
      return terms;
    case LensModel::kRadTanThinPrismFisheye:
      terms.bend = LensTerms::Bend::kAngle;
      set_over({p[4], p[5], p[6], p[7], p[8], p[9]});
      terms.p2 = p[10],
      terms.p1 = p[11];  // in this order; the others have them the other way round
      terms.prism_2 = {p[12], p[14]}, terms.prism_4 = {p[13], p[15]};
      terms.in_turn = true;
      return terms;
    case LensModel::kSimpleDivision:
      terms = one_focal(LensTerms::Bend::kDivision, 0, 0);
      terms.division = p[3];
      return terms;
    case LensModel::kDivision:
      terms.bend = LensTerms::Bend::kDivision;
      terms.division = p[4];
      return terms;
    case LensModel::kSimpleFisheye:
      return one_focal(LensTerms::Bend::kAngle, 0, 0);
    case LensModel::kFisheye:
      terms.bend = LensTerms::Bend::kAngle;
      return terms;
    case LensModel::kEucm:
      terms.bend = LensTerms::Bend::kUnified;
      terms.alpha = p[4], terms.beta = p[5];
      return terms;
    default:
      throw DataError(ComplaintOnLensModel(fmt::to_string(int(lens.model))));
  }
}

namespace {

// The bent distance of a distance r from the axis in the plane z = 1. kAngle: the angle from the
// axis (equidistant fisheye; Kannala and Brandt 2006). kFov: Devernay and Faugeras, "Straight lines
// have to be straight", 2001. kDivision: the b that solves r = b / (1 + k b^2) (Fitzgibbon 2001),
// NaN if none does. kUnified: Khomutenko, Garcia and Martinet, "An enhanced unified camera model",
// 2016, equation 12.
double BentRadius(const LensTerms& terms, double r) {
  switch (terms.bend) {
    case LensTerms::Bend::kNone:
      return r;
    case LensTerms::Bend::kAngle:
      return std::atan(r);
    case LensTerms::Bend::kFov:
      return terms.omega == 0 ? r : std::atan(2 * r * std::tan(0.5 * terms.omega)) / terms.omega;
    case LensTerms::Bend::kDivision:
      return 2 * r / (1 + std::sqrt(1 - 4 * terms.division * r * r));
    case LensTerms::Bend::kUnified:
      return r / (terms.alpha * std::sqrt(terms.beta * r * r + 1) + 1 - terms.alpha);
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

// The inverse of BentRadius; none if the angle is 90 degrees or more or, for kDivision, if no
// distance is bent to `bent`.
std::optional<double> UnbentRadius(const LensTerms& terms, double bent) {
  switch (terms.bend) {
    case LensTerms::Bend::kNone:
      return bent;
    case LensTerms::Bend::kAngle:
      return TangentOf(bent);
    case LensTerms::Bend::kFov: {
      if (terms.omega == 0) return bent;
      const std::optional<double> tangent = TangentOf(bent * std::abs(terms.omega));
      if (!tangent) return std::nullopt;
      return *tangent / (2 * std::tan(0.5 * std::abs(terms.omega)));
    }
    case LensTerms::Bend::kDivision: {
      const double k = terms.division * bent * bent;
      return k < 1 ? AtDepth(bent, 1 + k) : std::nullopt;  // r falls again beyond k b^2 = 1
    }
    case LensTerms::Bend::kUnified: {
      const double a = terms.alpha, bb = terms.beta * bent * bent;
      return AtDepth(bent, (1 - a * a * bb) / (a * std::sqrt(1 - (2 * a - 1) * bb) + 1 - a));
    }
  }
  throw BugError("unknown bend");
}

}  // namespace

glm::dvec2 Bent(const LensTerms& terms, const glm::dvec2& direction) {
  if (terms.bend == LensTerms::Bend::kNone) return direction;
  const double r = glm::length(direction);
  // On the axis the factor tends to the derivative, which r this small gives to all digits.
  constexpr double kTiny = 1e-9;
  return direction * (r > kTiny ? BentRadius(terms, r) / r : BentRadius(terms, kTiny) / kTiny);
}

std::optional<glm::dvec2> Unbent(const LensTerms& terms, const glm::dvec2& bent) {
  const double r = glm::length(bent);
  constexpr double kTiny = 1e-9;
  const std::optional<double> unbent = UnbentRadius(terms, std::max(r, kTiny));
  if (!unbent) return std::nullopt;
  return bent * (*unbent / std::max(r, kTiny));
}

namespace {

// The radial factor (1 + k1 r^2 + ...) / (1 + k4 r^2 + ...) and its derivative with respect to r^2.
struct Radial {
  double factor, slope;
};

Radial RadialAt(const LensTerms& terms, double rr) {
  const double(&k)[6] = terms.over, (&d)[3] = terms.under;
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

// x: 2 p1 x y + p2 (r^2 + 2 x^2) + prism; y likewise, with p1 and p2 exchanged.
glm::dvec2 SideShift(const LensTerms& terms, const glm::dvec2& q) {
  const double xy = q.x * q.y, rr = glm::dot(q, q);
  return glm::dvec2(2 * terms.p1 * xy + terms.p2 * (rr + 2 * q.x * q.x),
                    2 * terms.p2 * xy + terms.p1 * (rr + 2 * q.y * q.y)) +
         rr * (terms.prism_2 + rr * terms.prism_4);
}

// The columns are the derivatives with respect to x and y.
glm::dmat2 SideShiftJacobian(const LensTerms& terms, const glm::dvec2& q) {
  const double mixed = 2 * (terms.p1 * q.x + terms.p2 * q.y);
  const glm::dvec2 prism = 2.0 * (terms.prism_2 + 2 * glm::dot(q, q) * terms.prism_4);
  return glm::dmat2(2 * terms.p1 * q.y + 6 * terms.p2 * q.x, mixed, mixed,
                    2 * terms.p2 * q.x + 6 * terms.p1 * q.y) +
         glm::outerProduct(prism, q);
}

glm::dvec2 Moved(const LensTerms& terms, const glm::dvec2& b) {
  const glm::dvec2 scaled = b * RadialAt(terms, glm::dot(b, b)).factor;
  return scaled + SideShift(terms, terms.in_turn ? scaled : b);
}

glm::dmat2 MovedJacobian(const LensTerms& terms, const glm::dvec2& b) {
  const auto [factor, slope] = RadialAt(terms, glm::dot(b, b));
  const glm::dmat2 scaling = glm::dmat2(factor) + 2 * slope * glm::outerProduct(b, b);
  if (!terms.in_turn) return scaling + SideShiftJacobian(terms, b);
  return scaling + SideShiftJacobian(terms, b * factor) * scaling;
}

}  // namespace

// A map that does both, along and across, has a positive determinant again.
bool IsFolded(const LensTerms& terms, const glm::dvec2& b) {
  const glm::dmat2 jacobian = MovedJacobian(terms, b);
  return !(glm::determinant(jacobian) > 0) || !(jacobian[0][0] + jacobian[1][1] > 0);
}

// Newton's iteration from `target` inwards. A step that leads to a folded place or to a larger
// error is halved.
std::optional<glm::dvec2> Unmoved(const LensTerms& terms, const glm::dvec2& target) {
  constexpr int kMaxSteps = 50, kMaxHalvings = 40;
  constexpr double kTolerance = 1e-10;  // in focal lengths: 1e-6 pixels in a large photo
  const auto error_at = [&](const glm::dvec2& b) { return glm::length(Moved(terms, b) - target); };
  const auto is_folded = [&](const glm::dvec2& b) { return IsFolded(terms, b); };
  glm::dvec2 b = target;
  for (int i = 0; i < kMaxHalvings && is_folded(b); ++i) b *= 0.5;
  double error = error_at(b);
  for (int i = 0; i < kMaxSteps; ++i) {
    if (is_folded(b)) return std::nullopt;
    if (error < kTolerance) return b;
    glm::dvec2 step = glm::inverse(MovedJacobian(terms, b)) * (target - Moved(terms, b));
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

glm::dvec2 DistortedPixel(const LensTerms& terms, const glm::dvec2& direction) {
  const glm::dvec2 d = Moved(terms, Bent(terms, direction));
  return {terms.fx * d.x + terms.cx, terms.fy * d.y + terms.cy};
}

void FailToUndistort(const glm::dvec2& pixel, const char* why) {
  throw DataError(fmt::format("the lens distortion cannot be undone at pixel ({:.0f}, {:.0f}), {}",
                              pixel.x, pixel.y, why));
}

glm::dvec2 MovedOfPixel(const LensTerms& terms, const glm::dvec2& pixel) {
  return {(pixel.x - terms.cx) / terms.fx, (pixel.y - terms.cy) / terms.fy};
}

glm::dvec2 DistortedImageFromCam(const Lens& lens, const glm::dvec2& direction) {
  return DistortedPixel(LensTermsOf(lens), direction);
}

glm::dvec2 CamFromDistortedImage(const Lens& lens, const glm::dvec2& pixel) {
  const LensTerms terms = LensTermsOf(lens);
  const std::optional<glm::dvec2> bent = Unmoved(terms, MovedOfPixel(terms, pixel));
  if (!bent) FailToUndistort(pixel, kLensFolds);
  const std::optional<glm::dvec2> direction = Unbent(terms, *bent);
  if (!direction) {
    const bool folds = terms.bend == LensTerms::Bend::kDivision && terms.division > 0;
    FailToUndistort(pixel, folds ? kLensFolds : "which looks 90 degrees or more off the axis");
  }
  return *direction;
}

}  // namespace tetrec
