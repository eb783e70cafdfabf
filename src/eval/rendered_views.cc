// Reads views.json.
#include "eval/rendered_views.h"

#include "core/file.h"
#include "scene/checked_json.h"

#include <fmt/format.h>

#include <set>

namespace tetrec {
namespace {

std::filesystem::path PathInside(const std::filesystem::path& folder, const CheckedJson& field) {
  const std::string relative = field.Text();
  if (!StaysInside(relative))
    field.Fail(fmt::format("is \"{}\", which leaves the folder", relative));
  return folder / relative;
}

}  // namespace

RenderedViews ReadRenderedViews(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / "views.json";
  const nlohmann::json file = ReadJson(path);
  const CheckedJson json(file, path);
  json.Field("schema").IntegerIn(1, 1);
  RenderedViews rendered;
  rendered.background = json.Field("background").Text();
  rendered.split = json.Field("split").Text();
  rendered.rays_per_pixel = int(json.Field("rays_per_pixel").IntegerIn(1, 1 << 16));
  rendered.width = int(json.Field("resolution").Item(0).IntegerIn(1, 1 << 16));
  rendered.height = int(json.Field("resolution").Item(1).IntegerIn(1, 1 << 16));
  const CheckedJson views = json.Field("views");
  if (views.Size() == 0) views.Fail("is empty: there is nothing to judge");
  std::set<std::string> names;
  for (size_t i = 0; i < views.Size(); ++i) {
    const CheckedJson item = views.Item(i);
    RenderedView view;
    view.name = item.Field("name").Text();
    if (!names.insert(view.name).second) {
      item.Field("name").Fail(fmt::format("is \"{}\" for the second time", view.name));
    }
    view.render = PathInside(folder, item.Field("render"));
    view.truth = PathInside(folder, item.Field("ground_truth"));
    const auto optional_path = [&](const char* field) -> std::optional<std::filesystem::path> {
      if (!item.Has(field) || file["views"][i][field].is_null()) return std::nullopt;
      return PathInside(folder, item.Field(field));
    };
    view.mask = optional_path("mask");
    view.seen = optional_path("seen");
    rendered.views.push_back(std::move(view));
  }
  return rendered;
}

}  // namespace tetrec
