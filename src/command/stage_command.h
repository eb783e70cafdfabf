// The command line of a stage: its inputs and options, and what it asks RunStage to do.
#pragma once

#include "core/stage.h"
#include "core/stage_input.h"

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

namespace tetrec {

struct StageRequest;

class StageCommand {
 public:
  // name: "tetrahedralize" for tetrec-tetrahedralize; version: raised when results change.
  StageCommand(std::string name, int version, const std::string& description);

  CLI::App& app() { return app_; }

  // A positional argument that is the folder of an earlier stage; one of `stages` must have written
  // it.
  void InputStage(const std::string& name, const std::string& help, std::set<std::string> stages,
                  bool required = true);
  // A positional argument or option ("PHOTOS", "--ground-truth") that is a file or folder from
  // outside; files are hashed into the key (folders: names, sizes and times of files inside).
  void InputPath(const std::string& name, const std::string& help, bool required = true);
  // Other files that an input file names inside itself are hashed into the key too.
  void AlsoHash(const std::string& input_name, FilesNamedBy files_of);
  // Marks an option as not changing results (device, logging): recorded, but not part of the key.
  void DoesNotChangeResults(CLI::Option* option);

  // Parses, checks and runs the stage; returns the exit code. Adds -o/--output (required), --resume
  // and --force. `check_options` may throw UsageError: it runs before anything is touched.
  int Run(int argc, char** argv, const std::function<void(Stage&)>& body,
          const std::function<void()>& check_options = {});

 private:
  struct InputSpec {
    std::string name;              // without leading dashes
    std::set<std::string> stages;  // empty: a path from outside
    std::filesystem::path path;
    CLI::Option* option = nullptr;
    FilesNamedBy files_of;
  };

  StageRequest MakeRequest(int argc, char** argv) const;
  nlohmann::json Options(bool with_effect_only) const;

  std::string name_;
  int version_;
  CLI::App app_;
  std::filesystem::path output_;
  bool resume_ = false, force_ = false;
  std::vector<std::unique_ptr<InputSpec>> inputs_;
  std::set<const CLI::Option*> without_effect_;
};

}  // namespace tetrec
