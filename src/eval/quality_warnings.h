// What a reader of the report should know before trusting its numbers, in plain words.
#pragma once

#include "eval/report.h"
#include "scene/scene.h"

#include <optional>
#include <string>
#include <vector>

namespace tetrec {

// One sentence for each thing that is wrong: held-out views far below the others or rendered
// in nearly one colour, few training views. A new check is a function in quality_warnings.cc and
// its call at the end.
std::vector<std::string> QualityWarnings(const std::vector<ViewScore>& scores,
                                         const std::optional<Scene>& scene);

}  // namespace tetrec
