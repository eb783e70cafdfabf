// Means of values around the pixels of a photo.
#pragma once

#include <glm/glm.hpp>

#include <vector>

namespace tetrec {

// Means over some ten pixels to each side. Where a surface is off, its pictures and the photos
// differ within a few pixels; what differs over more is light and exposure: on a turntable, the
// light stands still while the subject turns, and a phone adapts its exposure as it moves.
class LocalMeans {
 public:
  LocalMeans(int width, int height);

  void Add(int x, int y, const glm::vec3& value);
  // Call this after the last Add and before the first At.
  void Smooth();
  // 0 where there are no values around.
  glm::vec3 At(int x, int y) const;

 private:
  struct Cell {
    glm::vec3 sum{0.0f};
    float count = 0;

    void Add(const Cell& other, float weight) {
      sum += weight * other.sum;
      count += weight * other.count;
    }
  };
  const Cell& CellAt(int column, int row) const {
    return cells_[size_t(row) * size_t(columns_) + size_t(column)];
  }

  int columns_, rows_;
  std::vector<Cell> cells_;  // (rows x columns)
};

}  // namespace tetrec
