// The run of a stage: decides whether there is anything to do, prepares the folder, calls the body,
// and records how it ended.
#pragma once

#include "core/stage.h"
#include "core/stage_input.h"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace tetrec {

struct StageRequest {
  std::string stage;                   // "optimize" for tetrec-optimize
  int version = 1;                     // raised when results change
  std::filesystem::path folder;        // to write
  nlohmann::json options;              // all of them, by name
  nlohmann::json options_with_effect;  // those that change results
  std::vector<StageInput> inputs;
  std::string command_line;  // for the records
  bool resume = false;       // refuse to start anew
  bool force = false;        // start anew, caches included

  // Hash of what determines the results: stage, version, options and inputs.
  std::string Key() const;
};

// Does nothing if the folder is up to date. Otherwise locks the folder and runs `body`; continues
// an earlier run with the same key that was cut off, and removes what any other run wrote: a
// finished result when the body declares its first output, so that a body that fails before leaves
// it as it was: then only the log records the failure, and the next run starts anew. Throws what
// the body throws (recorded in status.json), UsageError if the folder is another's, DataError if
// `resume` is set and no earlier run of the same key was cut off, and EnvironmentError.
void RunStage(const StageRequest& request, const std::function<void(Stage&)>& body);

}  // namespace tetrec
