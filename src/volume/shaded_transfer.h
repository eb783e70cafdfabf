// A transfer function prepared for rays: pieces of the sample's range within which opacity is
// linear and colour smooth, with display-sRGB colours in tables.
#pragma once

#include "volume/transfer_function.h"

#include <glm/glm.hpp>

#include <array>
#include <vector>

namespace tetrec {

class ShadedTransfer {
 public:
  explicit ShadedTransfer(const TransferFunction& function);

  // Pieces are numbered by rising sample; piece i lies between knots i and i + 1.
  int PieceCount() const { return int(pieces_.size()); }
  // The piece of a sample in [0, 1].
  int PieceOf(float sample) const {
    int piece = first_piece_[size_t(sample * kBins)];
    while (piece + 1 < PieceCount() && sample >= pieces_[size_t(piece) + 1].begin) ++piece;
    return piece;
  }
  float Knot(int i) const { return i < PieceCount() ? pieces_[size_t(i)].begin : 1.0f; }
  // Opacity within the piece: offset + slope * sample.
  float OpacityOffset(int piece) const { return pieces_[size_t(piece)].opacity_offset; }
  float OpacitySlope(int piece) const { return pieces_[size_t(piece)].opacity_slope; }
  // True if any of the pieces has opacity above 0.
  bool IsVisible(int first_piece, int last_piece) const {
    return visible_before_[size_t(last_piece) + 1] > visible_before_[size_t(first_piece)];
  }
  // Display sRGB, accurate to kColorError except where it runs through all of sRGB within 1/32 of
  // the range.
  glm::vec3 SrgbAt(int piece, float sample) const {
    const Piece& p = pieces_[size_t(piece)];
    const float at = glm::clamp((sample - p.begin) * p.colors_by_sample, 0.0f, p.last_color);
    const int i = int(at);
    const glm::vec3* color = &colors_[p.first_color + size_t(i)];
    return color[0] + (at - float(i)) * (color[1] - color[0]);
  }

  static constexpr double kColorError = 1.0 / 4096;

 private:
  static constexpr int kBins = 1024;
  struct Piece {
    float begin = 0;  // sample
    float opacity_offset = 0, opacity_slope = 0;
    float colors_by_sample = 0, last_color = 0;  // in steps of the table
    size_t first_color = 0;                      // in colors_
  };

  void AddColors(const TransferFunction& function, double begin, double end, Piece& piece);

  std::vector<Piece> pieces_;
  std::vector<int> visible_before_;           // number of earlier pieces with opacity above 0
  std::vector<glm::vec3> colors_;             // the tables of all pieces, each with one extra entry
  std::array<int, kBins + 1> first_piece_{};  // of each bin of samples
};

}  // namespace tetrec
