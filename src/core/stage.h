// A stage: an executable that reads the folder of the stage before it and writes its own.
//
// A stage folder holds manifest.json (written last and by rename: it exists only where the stage
// succeeded), status.json, log.txt and the stage's own files. A stage decides by key whether it is
// up to date: key = hash(stage, version, options that change results, hashes of inputs).
#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <chrono>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

namespace tetrec {

// A running stage, as its library call sees it.
class Stage {
 public:
  // Folder of an input that was declared with StageCommand::InputStage or InputPath.
  std::filesystem::path Input(const std::string& name) const;
  bool HasInput(const std::string& name) const;
  // Manifest of an input stage.
  const nlohmann::json& InputManifest(const std::string& name) const;
  const std::filesystem::path& folder() const { return folder_; }
  // Path of a file or subfolder of the stage's own folder; recorded in the manifest with its hash
  // when the stage ends (folders: every file inside).
  std::filesystem::path Output(const std::string& relative);
  // Scratch that is removed when the stage succeeds.
  std::filesystem::path Scratch(const std::string& relative);
  // Work that other options can use again: it stays when the stage succeeds, is no output, and a
  // run with another key finds it. Name what it depends on in its path. --force removes it.
  std::filesystem::path Cache(const std::string& relative);
  // True where `--resume` was given, or the earlier run of the same key was cut off.
  bool resume() const { return resume_; }
  const std::string& key() const { return key_; }

  void Count(const std::string& name, const nlohmann::json& value) { counts_[name] = value; }
  void Seconds(const std::string& name, double seconds) { seconds_[name] = seconds; }
  void Device(const nlohmann::json& device) { device_ = device; }
  // Free facts for the manifest, e.g. names of unregistered pictures.
  void Note(const std::string& name, const nlohmann::json& value) { notes_[name] = value; }

 private:
  friend class StageCommand;
  // Records in status.json that a path (or the top folder that it lies in) is ours, before anything
  // is written to it.
  std::filesystem::path Declare(const std::string& relative, const char* role, bool by_top_name);

  std::filesystem::path folder_;
  nlohmann::json status_;  // as in status.json
  std::map<std::string, std::filesystem::path> inputs_;
  std::map<std::string, nlohmann::json> input_manifests_;
  std::set<std::string> outputs_;
  std::string key_;
  bool resume_ = false;
  nlohmann::json counts_ = nlohmann::json::object(), seconds_ = nlohmann::json::object(),
                 notes_ = nlohmann::json::object(), device_ = nullptr;
};

// The command line of a stage and everything around its one library call.
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
  // Other files that an input file names inside itself; they are hashed into the key too.
  // `files_of` gets the input's path.
  void FilesNamedBy(
      const std::string& input_name,
      std::function<std::vector<std::filesystem::path>(const std::filesystem::path&)> files_of);
  // Marks an option as not changing results (device, logging): recorded, but not part of the key.
  void DoesNotChangeResults(CLI::Option* option);

  // Parses, checks, decides by key, runs, writes the manifest; returns the exit code. Adds
  // -o/--output (required), --resume, --force. `check_options` may throw UsageError: it runs before
  // anything is touched.
  int Run(int argc, char** argv, const std::function<void(Stage&)>& body,
          const std::function<void()>& check_options = {});

 private:
  struct InputSpec {
    std::string name;              // without leading dashes
    std::set<std::string> stages;  // empty: a path from outside
    std::filesystem::path path;
    CLI::Option* option = nullptr;
    std::function<std::vector<std::filesystem::path>(const std::filesystem::path&)> files_of;
  };
  struct Request;  // what the command line asks for, with its key

  Request MakeRequest() const;
  nlohmann::json Options(bool with_effect_only) const;
  void RunLocked(const Request& request, const std::string& command_line,
                 const std::function<void(Stage&)>& body);
  void Finish(Stage& stage, const Request& request, double seconds);

  std::string name_;
  int version_;
  CLI::App app_;
  std::filesystem::path output_;
  bool resume_ = false, force_ = false;
  std::vector<std::unique_ptr<InputSpec>> inputs_;
  std::set<const CLI::Option*> without_effect_;
};

// Reads manifest.json of a finished stage. Throws DataError: not a stage folder, another stage's
// folder, or a stage that did not finish (with the status and what to run).
nlohmann::json ReadManifest(const std::filesystem::path& folder,
                            const std::set<std::string>& stages);

// The nearest folder before `folder` in the chain of manifests that one of `stages` wrote. Throws
// DataError where the chain ends before, or its folder was moved away.
std::filesystem::path PreviousStage(const std::filesystem::path& folder,
                                    const std::set<std::string>& stages);

// Set by SIGINT and SIGTERM from the start of StageCommand::Run on; a second signal ends at once.
bool StopRequested();
// Throws Interrupted where a stop was requested; `saved` says what is kept.
void ThrowIfStopRequested(const std::string& saved);

// Wall-clock timer.
class Timer {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace tetrec
