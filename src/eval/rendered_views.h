// The folder that tetrec-render writes: pictures beside the truth, and how they were made.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace tetrec {

struct RenderedView {
  std::string name;                           // "test/r_0"
  std::filesystem::path render, truth;        // pictures of the same size, over the same background
  std::optional<std::filesystem::path> mask;  // grey; at least 128 on the subject
  std::optional<std::filesystem::path> seen;  // grey; at least 128 where the truth is known
};

struct RenderedViews {
  std::string background;  // "white", "black" or "scene"
  std::string split;       // "test", "validation", "train" or "all"
  int rays_per_pixel = 0;
  int width = 0, height = 0;  // [px] of the largest picture
  std::vector<RenderedView> views;
};

// Reads views.json (schema 1). Throws DataError naming file and field: another schema, no view, a
// name twice, a path that leaves the folder. Views without a true picture (a camera path) cannot be
// judged and are refused too.
RenderedViews ReadRenderedViews(const std::filesystem::path& folder);

}  // namespace tetrec
