// Writes and reads the frame of the JSON files about views.
#include "run/named_views.h"

#include <fmt/format.h>

#include <set>
#include <string>

namespace tetrec {
namespace {

constexpr int kNamesSchema = 1;

}  // namespace

nlohmann::json NamedViewsFile(nlohmann::json views) {
  return {{"schema", kNamesSchema}, {"views", std::move(views)}};
}

std::vector<CheckedJson> NamedViews(const CheckedJson& file) {
  file.Field("schema").IntegerIn(kNamesSchema, kNamesSchema);
  const CheckedJson views = file.Field("views");
  std::vector<CheckedJson> items;
  std::set<std::string> names;
  for (size_t i = 0; i < views.Size(); ++i) {
    const CheckedJson name = views.Item(i).Field("name");
    if (!names.insert(name.Text()).second) {
      name.Fail(fmt::format("is \"{}\" for the second time", name.Text()));
    }
    items.push_back(views.Item(i));
  }
  return items;
}

}  // namespace tetrec
