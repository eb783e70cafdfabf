// A box of cells, each inside or outside an object.
#pragma once

#include "geometry/bounds3.h"

#include <glm/glm.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace tetrec {

struct OccupancyGrid {
  Bounds3 bounds;               // [world units]
  glm::ivec3 size{0};           // cells along x, y, z
  std::vector<uint8_t> inside;  // size.z x size.y x size.x, x fastest; 1 inside, 0 outside

  size_t Index(int x, int y, int z) const {
    return (size_t(z) * size_t(size.y) + size_t(y)) * size_t(size.x) + size_t(x);
  }
  // False outside the grid.
  bool Inside(const glm::ivec3& cell) const {
    return cell.x >= 0 && cell.y >= 0 && cell.z >= 0 && cell.x < size.x && cell.y < size.y &&
           cell.z < size.z && inside[Index(cell.x, cell.y, cell.z)] != 0;
  }
  glm::dvec3 CellSize() const { return bounds.Size() / glm::dvec3(size); }
  glm::dvec3 CellCenter(int x, int y, int z) const {
    return bounds.min + (glm::dvec3(x, y, z) + 0.5) * CellSize();
  }
  // May be outside the grid.
  glm::ivec3 CellOf(const glm::dvec3& point) const {
    return glm::ivec3(glm::floor((point - bounds.min) / CellSize()));
  }
  size_t InsideCount() const {
    return size_t(std::count(inside.begin(), inside.end(), uint8_t{1}));
  }
  // Box of the inside cells; empty if there are none.
  Bounds3 InsideBounds() const {
    Bounds3 box;
    for (int z = 0; z < size.z; ++z) {
      for (int y = 0; y < size.y; ++y) {
        for (int x = 0; x < size.x; ++x) {
          if (inside[Index(x, y, z)] == 0) continue;
          box.Add(CellCenter(x, y, z) - 0.5 * CellSize());
          box.Add(CellCenter(x, y, z) + 0.5 * CellSize());
        }
      }
    }
    return box;
  }
};

// Number of cells along each axis that makes the cells nearly cubic, with `cells` along the longest
// side.
inline glm::ivec3 CubicCells(const Bounds3& bounds, int cells) {
  const glm::dvec3 size = bounds.Size();
  const double longest = std::max({size.x, size.y, size.z});
  return glm::max(glm::ivec3(glm::round(size / longest * double(cells))), glm::ivec3(1));
}

}  // namespace tetrec
