// Transfer functions prepared for rays.
#include "volume/shaded_transfer.h"

#include <algorithm>
#include <set>

namespace tetrec {
namespace {

// Bounds a slope: between two of the smallest floats it could overflow, and infinity times 0 is not
// a number.
float Steepness(double by_sample) {
  constexpr double kSteepest = 1e30;
  return float(std::clamp(by_sample, -kSteepest, kSteepest));
}

}  // namespace

ShadedTransfer::ShadedTransfer(const TransferFunction& function) {
  std::set<double> knots = {0.0, 1.0};
  for (const TransferFunction::OpacityPoint& point : function.opacity) knots.insert(point.x);
  for (const TransferFunction::ColorPoint& point : function.color) knots.insert(point.x);

  visible_before_ = {0};
  for (auto knot = knots.begin(); std::next(knot) != knots.end(); ++knot) {
    const double begin = *knot, end = *std::next(knot);
    // Knots that are equal in float, the type of samples, would give an empty piece.
    if (float(begin) == float(end)) continue;
    const double opacity0 = function.OpacityAt(begin), opacity1 = function.OpacityAt(end);
    const double slope = (opacity1 - opacity0) / (end - begin);
    Piece piece;
    piece.begin = float(begin);
    piece.opacity_slope = Steepness(slope);
    piece.opacity_offset = float(opacity0 - slope * begin);
    AddColors(function, begin, end, piece);
    pieces_.push_back(piece);
    const bool visible = opacity0 > 0 || opacity1 > 0;
    visible_before_.push_back(visible_before_.back() + (visible ? 1 : 0));
  }
  for (int bin = 0, piece = 0; bin <= kBins; ++bin) {
    while (piece + 1 < PieceCount() && float(bin) / kBins >= pieces_[size_t(piece) + 1].begin) {
      ++piece;
    }
    first_piece_[size_t(bin)] = piece;
  }
}

// Adds as many entries as linear interpolation between them needs, checked at their midpoints, but
// none closer than kFinest, so that a function with many steep points takes no more memory than a
// smooth one.
void ShadedTransfer::AddColors(const TransferFunction& function, double begin, double end,
                               Piece& piece) {
  constexpr double kFinest = 1.0 / (1 << 16);
  const auto color_at = [&](double fraction) {
    return function.SrgbAt(begin + fraction * (end - begin));
  };
  const auto is_fine = [&](int steps) {
    for (int i = 0; i < steps; ++i) {
      const glm::dvec3 before = color_at(double(i) / steps), after = color_at((i + 1.0) / steps);
      const glm::dvec3 error = glm::abs(color_at((i + 0.5) / steps) - 0.5 * (before + after));
      if (std::max({error.r, error.g, error.b}) > kColorError) return false;
    }
    return true;
  };
  int steps = 1;
  while (2 * steps * kFinest <= end - begin && !is_fine(steps)) steps *= 2;
  piece.first_color = colors_.size();
  piece.colors_by_sample = Steepness(steps / (end - begin));
  piece.last_color = float(steps);
  for (int i = 0; i <= steps; ++i) colors_.push_back(glm::vec3(color_at(double(i) / steps)));
  colors_.push_back(colors_.back());  // read with weight 0 at the end of the range
}

}  // namespace tetrec
