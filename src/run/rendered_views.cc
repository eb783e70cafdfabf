// Writes and reads views.json (schema 1).
#include "run/rendered_views.h"

#include "core/error_context.h"
#include "core/file.h"
#include "run/named_views.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace tetrec {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr int kMostRaysPerPixel = 1 << 16, kMaxSide_px = 1 << 16;
constexpr double kLargestRefinedShift_px = 1e6;

fs::path PathInside(const fs::path& folder, const CheckedJson& field) {
  const std::string relative = field.Text();
  if (!StaysInside(relative)) {
    field.Fail(fmt::format("is \"{}\", which leaves the folder", relative));
  }
  return folder / relative;
}

// Null, like a missing field, means that there is no such image.
std::optional<fs::path> OptionalPathInside(const fs::path& folder, const CheckedJson& view,
                                           const char* name) {
  if (!view.Has(name) || view.Field(name).IsNull()) return std::nullopt;
  return PathInside(folder, view.Field(name));
}

RenderedView ReadView(const fs::path& folder, const CheckedJson& item) {
  RenderedView view;
  view.name = item.Field("name").Text();
  if (item.Has("split")) view.split = item.Field("split").Text();
  view.render = PathInside(folder, item.Field("render"));
  view.truth = PathInside(folder, item.Field("ground_truth"));
  view.mask = OptionalPathInside(folder, item, "mask");
  view.seen = OptionalPathInside(folder, item, "seen");
  view.depth = OptionalPathInside(folder, item, "depth");
  view.normals = OptionalPathInside(folder, item, "normals");
  view.refined = OptionalPathInside(folder, item, "refined");
  if (item.Has("refined_shift_px") && !item.Field("refined_shift_px").IsNull()) {
    view.refined_shift_px = item.Field("refined_shift_px").NumberIn(0, kLargestRefinedShift_px);
  }
  return view;
}

}  // namespace

void WriteRenderedViews(const fs::path& path, const RenderedViews& rendered) {
  const fs::path folder = path.parent_path();
  const auto in_folder = [&](const fs::path& file) {
    return file.lexically_relative(folder).generic_string();
  };
  const auto in_folder_or_null = [&](const std::optional<fs::path>& file) {
    return file ? json(in_folder(*file)) : json(nullptr);
  };
  // A scene has masks of one kind; views without one state its kind too.
  const bool has_seen = std::any_of(rendered.views.begin(), rendered.views.end(),
                                    [](const RenderedView& view) { return view.seen.has_value(); });
  json views = json::array();
  for (const RenderedView& view : rendered.views) {
    const std::optional<fs::path>& mask = has_seen ? view.seen : view.mask;
    views.push_back({{"name", view.name},
                     {"split", view.split},
                     {"render", in_folder(view.render)},
                     {"ground_truth", in_folder(view.truth)},
                     {has_seen ? "seen" : "mask", in_folder_or_null(mask)},
                     {"depth", in_folder_or_null(view.depth)},
                     {"normals", in_folder_or_null(view.normals)},
                     {"refined", in_folder_or_null(view.refined)},
                     {"refined_shift_px",
                      view.refined_shift_px ? json(*view.refined_shift_px) : json(nullptr)}});
  }
  json value = NamedViewsFile(std::move(views));
  value["background"] = rendered.background;
  value["rays_per_pixel"] = rendered.rays_per_pixel;
  value["split"] = rendered.split;
  value["resolution"] = {rendered.width, rendered.height};
  ParseRenderedViews(value, path);
  WriteJson(path, value);
}

RenderedViews ParseRenderedViews(const json& value, const fs::path& path) {
  const CheckedJson file(value, path);
  const std::vector<CheckedJson> views = NamedViews(file);
  if (views.empty()) file.Field("views").Fail("is empty: there is nothing to judge");
  RenderedViews rendered;
  rendered.background = file.Field("background").Text();
  rendered.split = file.Field("split").Text();
  rendered.rays_per_pixel = int(file.Field("rays_per_pixel").IntegerIn(1, kMostRaysPerPixel));
  rendered.width = int(file.Field("resolution").Item(0).IntegerIn(1, kMaxSide_px));
  rendered.height = int(file.Field("resolution").Item(1).IntegerIn(1, kMaxSide_px));
  std::set<fs::path> renders;
  for (const CheckedJson& item : views) {
    RenderedView view = ReadView(path.parent_path(), item);
    // Earlier versions rendered frame.0000 and frame.0001 into one file.
    if (!renders.insert(view.render.lexically_normal()).second) {
      item.Field("render").Fail(
          fmt::format("is \"{}\", the image of an earlier view", item.Field("render").Text()));
    }
    rendered.views.push_back(std::move(view));
  }
  return rendered;
}

RenderedViews ReadRenderedViews(const fs::path& path) {
  return Advising("run tetrec-render again",
                  [&] { return ParseRenderedViews(ReadJson(path), path); });
}

}  // namespace tetrec
