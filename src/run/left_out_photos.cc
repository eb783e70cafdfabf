// Writes and reads left_out.json (schema 1).
#include "run/left_out_photos.h"

#include "core/error_context.h"
#include "core/file.h"
#include "run/named_views.h"

namespace tetrec {
namespace {

using nlohmann::json;

std::vector<std::string> Parse(const json& value, const std::string& name) {
  std::vector<std::string> names;
  for (const CheckedJson& view : NamedViews(CheckedJson(value, name))) {
    names.push_back(view.Field("name").Text());
  }
  return names;
}

}  // namespace

void WriteLeftOutPhotos(const std::filesystem::path& path, const std::vector<std::string>& names) {
  json views = json::array();
  for (const std::string& name : names) views.push_back({{"name", name}});
  const json value = NamedViewsFile(std::move(views));
  Parse(value, path.string());
  WriteJson(path, value);
}

std::vector<std::string> ReadLeftOutPhotos(const std::filesystem::path& path) {
  return Advising("run tetrec-optimize again",
                  [&] { return Parse(ReadJson(path), path.string()); });
}

}  // namespace tetrec
