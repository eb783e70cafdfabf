// Pull and push over a pyramid of means.
#include "surface/continue_colors.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace tetrec {
namespace {

// Colours of 0 to 255; those of unknown pixels do not count.
struct Level {
  int width, height;
  std::vector<std::array<uint8_t, 3>> colors;
  std::vector<bool> known;

  size_t Index(int x, int y) const { return size_t(y) * size_t(width) + size_t(x); }
};

Level Coarser(const Level& fine) {
  Level coarse{(fine.width + 1) / 2, (fine.height + 1) / 2, {}, {}};
  for (int y = 0; y < coarse.height; ++y) {
    for (int x = 0; x < coarse.width; ++x) {
      std::array<double, 3> sum{};
      int count = 0;
      for (int j = 2 * y; j < std::min(2 * y + 2, fine.height); ++j) {
        for (int i = 2 * x; i < std::min(2 * x + 2, fine.width); ++i) {
          if (!fine.known[fine.Index(i, j)]) continue;
          for (size_t c = 0; c < 3; ++c) sum[c] += fine.colors[fine.Index(i, j)][c];
          ++count;
        }
      }
      coarse.known.push_back(count > 0);
      auto& mean = coarse.colors.emplace_back();
      for (size_t c = 0; c < 3 && count > 0; ++c) mean[c] = uint8_t(std::lround(sum[c] / count));
    }
  }
  return coarse;
}

}  // namespace

void ContinueColors(Image& image, const std::function<bool(size_t)>& is_known) {
  Level finest{image.width, image.height, {}, {}};
  for (size_t i = 0; i < size_t(image.width) * size_t(image.height); ++i) {
    finest.known.push_back(is_known(i));
    finest.colors.push_back(
        {image.pixels[3 * i], image.pixels[3 * i + 1], image.pixels[3 * i + 2]});
  }
  std::vector<Level> levels{std::move(finest)};
  while (levels.back().width > 1 || levels.back().height > 1) {
    levels.push_back(Coarser(levels.back()));
  }
  for (size_t l = levels.size() - 1; l-- > 0;) {
    Level& fine = levels[l];
    const Level& coarse = levels[l + 1];
    for (int y = 0; y < fine.height; ++y) {
      for (int x = 0; x < fine.width; ++x) {
        if (fine.known[fine.Index(x, y)]) continue;
        fine.colors[fine.Index(x, y)] = coarse.colors[coarse.Index(x / 2, y / 2)];
      }
    }
  }
  for (size_t i = 0; i < levels[0].colors.size(); ++i) {
    for (size_t c = 0; c < 3; ++c) image.pixels[3 * i + c] = levels[0].colors[i][c];
  }
}

}  // namespace tetrec
