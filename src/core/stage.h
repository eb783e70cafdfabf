// A running stage, as its library call sees it. (stage_run.h runs it.)
//
// A stage is an executable that reads the folder of the stage before it and writes its own folder,
// which contains manifest.json, status.json, log.txt and the stage's own files.
#pragma once

#include "core/timer.h"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace tetrec {

class Stage {
 public:
  // Path of an input that was declared by StageCommand::InputStage or InputPath.
  std::filesystem::path Input(const std::string& name) const;
  bool HasInput(const std::string& name) const;
  const std::filesystem::path& folder() const { return folder_; }
  // Path of a file or subfolder of the stage's own folder; recorded in the manifest with its hash
  // when the stage ends (folders: every file inside).
  std::filesystem::path Output(const std::string& relative);
  // Scratch that is removed when the stage succeeds, or fails while an earlier result stays.
  std::filesystem::path Scratch(const std::string& relative);
  // Work that runs with other options can use again: it stays when the stage succeeds, is not an
  // output, and a run with another key finds it. Name what it depends on in its path. A forced run
  // removes it.
  std::filesystem::path Cache(const std::string& relative);
  // True if an earlier run with the same key was cut off and this one continues it.
  bool resume() const { return resume_; }
  const std::string& key() const { return key_; }

  void Count(const std::string& name, const nlohmann::json& value) { counts_[name] = value; }
  void Seconds(const std::string& name, double seconds) { seconds_[name] = seconds; }
  // Records the seconds so far in status.json, so that a run that continues this one after a kill
  // counts them, too.
  void KeepSeconds();
  void Device(const nlohmann::json& device) { device_ = device; }
  // Warns of something that the result lacks although it may be there another time, such as a
  // program or a device. The same command then runs again instead of finding the folder up to date.
  void Degrade(const std::string& why);
  // Other facts for the manifest, e.g. names of unregistered photos.
  void Note(const std::string& name, const nlohmann::json& value) { notes_[name] = value; }

 private:
  friend class StageRun;
  // Records in status.json that a path (or the top folder that contains it) is ours, before
  // anything is written to it.
  std::filesystem::path Declare(const std::string& relative, const char* role, bool by_top_name);
  void RemoveEarlierResult();
  void RemoveEarlierCaches();
  double TotalSeconds() const { return seconds_before_ + timer_.seconds(); }

  std::filesystem::path folder_;
  Timer timer_;
  double seconds_before_ = 0;  // of the run that this one continues
  nlohmann::json status_;      // as in status.json
  // Removes an earlier result, before the first output is declared; empty then. A run that fails
  // before leaves that result as it is.
  std::function<void()> remove_earlier_result_;
  // In a forced run: removes earlier caches, before the first cache is declared; empty then.
  std::function<void()> remove_earlier_caches_;
  std::map<std::string, std::filesystem::path> inputs_;
  std::set<std::string> outputs_;
  std::vector<std::string> degraded_;
  std::string key_;
  bool resume_ = false;
  nlohmann::json counts_ = nlohmann::json::object(), seconds_ = nlohmann::json::object(),
                 notes_ = nlohmann::json::object(), device_ = nullptr;
};

}  // namespace tetrec
