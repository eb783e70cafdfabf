// The frame of the JSON files about views: {"schema": 1, "views": [{"name": "...", ...}, ...],
// ...}.
#pragma once

#include "core/checked_json.h"

#include <nlohmann/json.hpp>

#include <vector>

namespace tetrec {

// A file of these views, to which other fields may be added.
nlohmann::json NamedViewsFile(nlohmann::json views);

// The items of "views". Throws DataError naming file and field: another schema, a view without a
// name, a view named twice. The items refer to the value that `file` refers to.
std::vector<CheckedJson> NamedViews(const CheckedJson& file);

}  // namespace tetrec
