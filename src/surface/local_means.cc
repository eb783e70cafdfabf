// Sums over the cells of a grid.
#include "surface/local_means.h"

#include <algorithm>
#include <utility>

namespace tetrec {
namespace {

constexpr int kCellSize_px = 8;

int CellsAlong(int pixels) { return (pixels + kCellSize_px - 1) / kCellSize_px; }

}  // namespace

LocalMeans::LocalMeans(int width, int height)
    : columns_(CellsAlong(width)), rows_(CellsAlong(height)) {
  cells_.resize(size_t(columns_) * size_t(rows_));
}

void LocalMeans::Add(int x, int y, const glm::vec3& value) {
  Cell& cell = cells_[size_t(y / kCellSize_px) * size_t(columns_) + size_t(x / kCellSize_px)];
  cell.Add({value, 1}, 1);
}

// Each cell becomes the binomially weighted sum of those around it.
void LocalMeans::Smooth() {
  std::vector<Cell> smooth(cells_.size());
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < columns_; ++column) {
      Cell& cell = smooth[size_t(row) * size_t(columns_) + size_t(column)];
      for (int y = std::max(row - 1, 0); y <= std::min(row + 1, rows_ - 1); ++y) {
        for (int x = std::max(column - 1, 0); x <= std::min(column + 1, columns_ - 1); ++x) {
          cell.Add(CellAt(x, y), (x == column ? 2.0f : 1.0f) * (y == row ? 2.0f : 1.0f));
        }
      }
    }
  }
  cells_ = std::move(smooth);
}

// Linear between the centres of the cells.
glm::vec3 LocalMeans::At(int x, int y) const {
  const auto along = [](int pixel, int cells) {
    const float place = (float(pixel) + 0.5f) / float(kCellSize_px) - 0.5f;
    return std::clamp(place, 0.0f, float(cells - 1));
  };
  const float u = along(x, columns_), v = along(y, rows_);
  const int left = int(u), top = int(v);
  const int right = std::min(left + 1, columns_ - 1), bottom = std::min(top + 1, rows_ - 1);
  const float from_left = u - float(left), from_top = v - float(top);
  Cell mean;
  mean.Add(CellAt(left, top), (1 - from_left) * (1 - from_top));
  mean.Add(CellAt(right, top), from_left * (1 - from_top));
  mean.Add(CellAt(left, bottom), (1 - from_left) * from_top);
  mean.Add(CellAt(right, bottom), from_left * from_top);
  return mean.count > 0 ? mean.sum / mean.count : glm::vec3(0.0f);
}

}  // namespace tetrec
