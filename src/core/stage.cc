// Inputs and declared paths of a running stage.
#include "core/stage.h"

#include "core/error.h"
#include "core/file.h"
#include "core/log.h"
#include "core/manifest.h"
#include "core/stage_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace tetrec {
namespace fs = std::filesystem;
using nlohmann::json;

fs::path Stage::Input(const std::string& name) const {
  TETREC_CHECK(HasInput(name), "no input named " + name);
  return inputs_.at(name);
}

bool Stage::HasInput(const std::string& name) const { return inputs_.contains(name); }

fs::path Stage::Declare(const std::string& relative, const char* role, bool by_top_name) {
  const fs::path path = fs::path(relative).lexically_normal();
  TETREC_CHECK(StaysInFolder(path), "not a path inside the stage folder: " + relative);
  // Another version's result may contain a file of this name.
  if (DeclaredPaths(status_, "own").contains(path.begin()->string())) RemoveEarlierResult();
  const json name = by_top_name ? path.begin()->string() : path.string();
  json& names = status_[role];
  if (std::find(names.begin(), names.end(), name) == names.end()) {
    names.push_back(name);
    WriteJson(folder_ / kStatusFile, status_);
  }
  const fs::path parent = (folder_ / path).parent_path();
  std::error_code error;
  fs::create_directories(parent, error);
  if (error)
    throw EnvironmentError(
        fmt::format("{}: cannot be made ({})", parent.string(), error.message()));
  return folder_ / path;
}

void Stage::RemoveEarlierResult() {
  if (remove_earlier_result_) std::exchange(remove_earlier_result_, nullptr)();
}

fs::path Stage::Output(const std::string& relative) {
  RemoveEarlierResult();
  outputs_.insert(relative);
  return Declare(relative, "own", true);
}

void Stage::KeepSeconds() {
  status_["seconds"] = TotalSeconds();
  WriteJson(folder_ / kStatusFile, status_);
}

void Stage::Degrade(const std::string& why) {
  LogWarning("{}", why);
  degraded_.push_back(why);
}

void Stage::RemoveEarlierCaches() {
  if (remove_earlier_caches_) std::exchange(remove_earlier_caches_, nullptr)();
}

fs::path Stage::Scratch(const std::string& relative) { return Declare(relative, "scratch", false); }

fs::path Stage::Cache(const std::string& relative) {
  RemoveEarlierCaches();
  return Declare(relative, "caches", true);
}

}  // namespace tetrec
