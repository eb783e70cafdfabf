// The pinhole camera that replaces a distorting lens: the largest window that the photo fills.
#include "geometry/undistorted_camera.h"

#include "core/error.h"
#include "geometry/lens_distortion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace tetrec {
namespace {

// A box of directions that the photo covers: the tightest along the undistorted borders.
struct Window {
  glm::dvec2 min, max;
  bool is_cut = false;                  // a fisheye sees more
  std::optional<glm::dvec2> folded_at;  // a border pixel that no direction reaches
};

const double kWidest = std::tan(std::numbers::pi / 3);  // 60 degrees

// The direction of a border pixel along axis 0 (x) or 1 (y). For fisheyes it is limited to
// `widest`, which also replaces directions behind the plane and beyond the fold of the lens model.
double BorderDirection(const LensTerms& terms, const glm::dvec2& pixel, int axis, double widest,
                       Window& window) {
  const glm::dvec2 moved = MovedOfPixel(terms, pixel);
  const std::optional<glm::dvec2> bent = Unmoved(terms, moved);
  if (!bent && !window.folded_at) window.folded_at = pixel;
  if (terms.bend == LensTerms::Bend::kNone) return bent ? (*bent)[axis] : 0;
  const std::optional<glm::dvec2> direction = bent ? Unbent(terms, *bent) : std::nullopt;
  if (!direction && !window.folded_at) window.folded_at = pixel;
  if (!direction) return std::copysign(widest, moved[axis]);
  return std::clamp((*direction)[axis], -widest, widest);
}

Window WindowUpTo(const Lens& lens, const LensTerms& terms, double widest) {
  const auto width = double(lens.width), height = double(lens.height);
  Window window{glm::dvec2(-1e9), glm::dvec2(1e9), false, std::nullopt};
  constexpr int kSteps = 256;
  for (int i = 0; i <= kSteps; ++i) {
    const double x = width * i / kSteps, y = height * i / kSteps;
    window.min.x = std::max(window.min.x, BorderDirection(terms, {0, y}, 0, widest, window));
    window.max.x = std::min(window.max.x, BorderDirection(terms, {width, y}, 0, widest, window));
    window.min.y = std::max(window.min.y, BorderDirection(terms, {x, 0}, 1, widest, window));
    window.max.y = std::min(window.max.y, BorderDirection(terms, {x, height}, 1, widest, window));
  }
  window.is_cut = terms.bend != LensTerms::Bend::kNone &&
                  (glm::any(glm::lessThanEqual(window.min, glm::dvec2(-widest))) ||
                   glm::any(glm::greaterThanEqual(window.max, glm::dvec2(widest))));
  return window;
}

// True if the lens model folds over somewhere in the window.
bool Folds(const LensTerms& terms, const Window& window) {
  constexpr int kSteps = 64;
  for (int j = 0; j <= kSteps; ++j) {
    for (int i = 0; i <= kSteps; ++i) {
      const glm::dvec2 share(double(i) / kSteps, double(j) / kSteps);
      if (IsFolded(terms, Bent(terms, glm::mix(window.min, window.max, share)))) return true;
    }
  }
  return false;
}

// The corners of the window look farther to the side than its borders. If the model folds over
// between the two, the corners end at kWidest.
Window CoveredWindow(const Lens& lens) {
  const LensTerms terms = LensTermsOf(lens);
  Window window = WindowUpTo(lens, terms, kWidest);
  const glm::dvec2 bad_pixel = window.folded_at.value_or(glm::dvec2(0));
  if (terms.bend == LensTerms::Bend::kNone) {
    if (window.folded_at) FailToUndistort(bad_pixel, kLensFolds);
    return window;
  }
  if (!Folds(terms, window)) return window;
  window = WindowUpTo(lens, terms, kWidest / std::numbers::sqrt2);
  if (Folds(terms, window)) FailToUndistort(bad_pixel, kLensFolds);
  return window;
}

}  // namespace

bool IsTooWideForPlane(const Lens& lens) { return CoveredWindow(lens).is_cut; }

Camera UndistortedCamera(const Lens& lens, int max_size) {
  const LensTerms terms = LensTermsOf(lens);
  if (!(terms.fx > 0) || !(terms.fy > 0)) {
    throw DataError(fmt::format(
        "a camera has the focal lengths {} and {} px; both must be positive", terms.fx, terms.fy));
  }
  Window window = CoveredWindow(lens);
  glm::dvec2 size = (window.max - window.min) * glm::dvec2(terms.fx, terms.fy);
  if (!(size.x >= 1 && size.y >= 1)) {
    throw DataError("the lens distortion leaves nothing of the image");
  }
  // Keep the photo's aspect ratio, so that the scene's images have the usual sizes.
  const double format = double(lens.width) / double(lens.height);
  const glm::dvec2 kept = glm::min(size, glm::dvec2(size.y * format, size.x / format));
  const glm::dvec2 cut = 0.5 * (size - kept) / glm::dvec2(terms.fx, terms.fy);
  window.min += cut;
  window.max -= cut;
  size = kept;

  // A barrel lens spreads the photo out: at its focal length there would be more pixels than the
  // photo has.
  const double longer = std::max(size.x, size.y);
  const double most = std::min(double(max_size), double(std::max(lens.width, lens.height)));
  const double scale = std::min(1.0, most / longer);
  Camera to;
  to.width = std::max(1, int(std::lround(size.x * scale)));
  to.height = std::max(1, int(std::lround(size.y * scale)));
  // The sizes are rounded, but the whole window still fills the whole image.
  to.fx = to.width / (window.max.x - window.min.x);
  to.fy = to.height / (window.max.y - window.min.y);
  to.cx = -window.min.x * to.fx;
  to.cy = -window.min.y * to.fy;
  return to;
}

}  // namespace tetrec
