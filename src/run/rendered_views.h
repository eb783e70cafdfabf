// views.json: the images that tetrec-render wrote, the ground truth beside them, and the protocol
// that both were made by.
#pragma once

#include <nlohmann/json.hpp>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace tetrec {

inline constexpr const char* kRenderedViewsFile = "views.json";

// Paths are below the folder of views.json.
struct RenderedView {
  std::string name;                     // of the scene's view, e.g. "test/r_0"
  std::string split;                    // of the view: "test"; empty if unknown
  std::filesystem::path render, truth;  // images of the same size over the same background
  // Grey images, at least 128 on what they select: the subject (mask), or the pixels whose truth is
  // known, outside of which nothing is scored (seen).
  std::optional<std::filesystem::path> mask, seen;
  // Depth of the field in world units (image/depth_map.h); earlier versions rendered none.
  std::optional<std::filesystem::path> depth;
  // Normals of that depth in the world frame (image/normal_map.h); earlier versions wrote none.
  std::optional<std::filesystem::path> normals;
  // The image from the refined camera, whose pose was fitted to the true image with the field as it
  // is, and how far that moved the picture [px]; nothing where no camera was refined.
  std::optional<std::filesystem::path> refined;
  std::optional<double> refined_shift_px;
};

struct RenderedViews {
  std::string background;  // "white", "black" or "scene"
  std::string split;       // "test", "validation", "train" or "all"
  int rays_per_pixel = 0;
  int width = 0, height = 0;  // [px] of the first view
  std::vector<RenderedView> views;
};

// {"schema": 1, "background", "rays_per_pixel", "split", "resolution": [width, height],
//  "views": [{"name", "split", "render", "ground_truth", "mask" or "seen": path or null,
//             "depth": path or null, "normals": path or null, "refined": path or null,
//             "refined_shift_px": number or null}]}
// Throw DataError naming file and field: another schema, no view, a name or an image given to two
// views, a path that leaves the folder, a view without ground truth (as on a camera path), which
// could not be scored. Writing refuses what reading would refuse.
void WriteRenderedViews(const std::filesystem::path& path, const RenderedViews& rendered);
RenderedViews ReadRenderedViews(const std::filesystem::path& path);
RenderedViews ParseRenderedViews(const nlohmann::json& value, const std::filesystem::path& path);

}  // namespace tetrec
