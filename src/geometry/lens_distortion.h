// The formulas of lens distortion: one set of terms for all models, forwards and backwards.
#pragma once

#include "geometry/lens.h"

#include <glm/glm.hpp>

#include <optional>

namespace tetrec {

// A direction (x, y, 1) is first bent (by fisheyes), then moved in the plane as in Brown,
// "Decentering distortion of lenses", 1966: by a radial factor, tangential terms and a thin prism.
struct LensTerms {
  enum class Bend { kNone, kAngle, kFov, kDivision, kUnified };
  double fx = 0, fy = 0, cx = 0, cy = 0;
  Bend bend = Bend::kNone;
  double omega = 0;                    // for kFov [rad]
  double division = 0;                 // for kDivision
  double alpha = 0, beta = 1;          // for kUnified
  double over[6] = {}, under[3] = {};  // the radial factor's coefficients of r^2, r^4, ...
  double p1 = 0, p2 = 0;
  glm::dvec2 prism_2{0.0}, prism_4{0.0};  // coefficients of r^2 and r^4
  // True if the tangential and prism terms are evaluated at the place to which the radial factor
  // moved the direction, false if they are evaluated at the place before.
  bool in_turn = false;
};

// Throws DataError for an unknown model.
LensTerms LensTermsOf(const Lens& lens);

// The bent direction, and its inverse: none if the direction is 90 degrees or more off the axis or
// if nothing bends to `bent`.
glm::dvec2 Bent(const LensTerms& terms, const glm::dvec2& direction);
std::optional<glm::dvec2> Unbent(const LensTerms& terms, const glm::dvec2& bent);

// True if, at the bent direction b, the image of a direction moves backwards while the direction
// moves outwards, along the radius or, mirrored, across it.
bool IsFolded(const LensTerms& terms, const glm::dvec2& b);

// The place in the plane of focal length 1 from which the focal lengths and the principal point
// make `pixel`.
glm::dvec2 MovedOfPixel(const LensTerms& terms, const glm::dvec2& pixel);
// The bent direction that is moved to `target`; none if the search does not reach it.
std::optional<glm::dvec2> Unmoved(const LensTerms& terms, const glm::dvec2& target);

// DistortedImageFromCam for many directions of one lens.
glm::dvec2 DistortedPixel(const LensTerms& terms, const glm::dvec2& direction);

constexpr const char* kLensFolds = "where the lens model folds over";
// Throws DataError: the distortion cannot be undone at the pixel, and why.
[[noreturn]] void FailToUndistort(const glm::dvec2& pixel, const char* why);

}  // namespace tetrec
