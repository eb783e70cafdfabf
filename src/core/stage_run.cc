// The run of a stage, from its folder to its manifest.
#include "core/stage_run.h"

#include "core/error.h"
#include "core/file.h"
#include "core/folder_lock.h"
#include "core/log.h"
#include "core/manifest.h"
#include "core/progress.h"
#include "core/stage_folder.h"
#include "core/stop_request.h"
#include "core/version.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

namespace tetrec {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

// Why the key differs, in words. `now` contains only options that change results.
std::string DifferenceOf(const json& before, const json& now) {
  const json old = before.value("options", json::object());
  std::vector<std::string> parts;
  for (const auto& [name, value] : now.items()) {
    const std::string was = old.contains(name) ? old[name].dump() : "unknown";
    if (was != value.dump())
      parts.push_back(fmt::format("{} (was {}, now {})", name, was, value.dump()));
  }
  if (parts.empty()) return "the input or the program's version";
  return fmt::format("{}", fmt::join(parts, ", "));
}

// A run that was killed before its first output has left its own status beside the manifest of the
// result that stays.
bool IsOfKilledRun(const json& status, const json& manifest) {
  return status.is_object() &&
         (status["key"] != manifest["key"] || TextOrEmpty(status, "status") != "done");
}

json StatusOfResult(const json& manifest, json status) {
  if (!IsOfKilledRun(status, manifest)) return status;
  for (const char* name : {"key", "options", "command"}) {
    if (manifest.contains(name)) status[name] = manifest[name];
  }
  status["own"] = ResultPaths(manifest, nullptr);
  status["scratch"] = json::array();
  status["status"] = "done";
  status["error"] = nullptr;
  return status;
}

// Removes what a killed run has left beside a result that is up to date, if the folder may be
// written.
void TidyUp(const fs::path& folder, const json& manifest) {
  if (!IsOfKilledRun(ReadManifestOrStatus(folder / kStatusFile), manifest) || IsLocked(folder)) {
    return;
  }
  try {
    const FolderLock lock(folder);
    const json status = ReadManifestOrStatus(folder / kStatusFile);
    // Another run may have ended meanwhile.
    if (ReadManifestOrStatus(folder / kManifestFile) != manifest) return;
    RefuseLinks(folder, status);
    RemoveDeclared(folder, status, "scratch");
    WriteJson(folder / kStatusFile, StatusOfResult(manifest, status));
  } catch (const Error&) {
    // The result is up to date all the same.
  }
}

void LogWarningsAgain(const std::vector<std::string>& warnings) {
  if (warnings.empty()) return;
  LogLine(LogLevel::kInfo,
          fmt::format("{} warning{}:", warnings.size(), warnings.size() == 1 ? "" : "s"));
  for (const std::string& warning : warnings) LogLine(LogLevel::kInfo, "  " + warning);
}

}  // namespace

// One run, inside the folder's lock.
class StageRun {
 public:
  explicit StageRun(const StageRequest& request);
  void Call(const std::function<void(Stage&)>& body);

 private:
  std::string WhyNotResumed() const;
  void RemoveEarlierRun();
  void KeepEarlierResult();
  void StartLog();
  void RecordFailure(const char* state, const std::string& message);
  void Finish();

  const StageRequest& request_;
  const json old_manifest_, old_status_;  // null if there are none
  uint64_t log_begin_ = 0;                // of this run in the log file
  Stage stage_;
};

StageRun::StageRun(const StageRequest& request)
    : request_(request),
      old_manifest_(ReadManifestOrStatus(request.folder / kManifestFile)),
      old_status_(ReadManifestOrStatus(request.folder / kStatusFile)) {
  stage_.folder_ = request.folder;
  stage_.key_ = request.Key();
  for (const StageInput& input : request.inputs) stage_.inputs_[input.name] = input.path;
  const bool same_key =
      old_status_.is_object() && old_status_["key"] == stage_.key_ && old_manifest_.is_null();
  if (request.resume && !same_key) {
    throw DataError(fmt::format("{}: cannot resume: {}", request.folder.string(), WhyNotResumed()));
  }
  stage_.resume_ = same_key && !request.force;
  stage_.status_ =
      StatusOfNewRun(request.stage, stage_.key_, request.options, request.command_line);
  stage_.status_["caches"] = DeclaredPaths(old_status_, "caches");
  if (request.force) {
    stage_.remove_earlier_caches_ = [this] {
      RemoveDeclared(request_.folder, old_status_, "caches");
      stage_.status_["caches"] = json::array();
    };
  }
  if (stage_.resume_) {
    for (const char* role : {"own", "scratch"})
      stage_.status_[role] = DeclaredPaths(old_status_, role);
    if (old_status_.contains("seconds") && old_status_["seconds"].is_number()) {
      stage_.seconds_before_ = old_status_["seconds"];
      stage_.status_["seconds"] = stage_.seconds_before_;
    }
  } else {
    RemoveDeclared(request.folder, old_status_, "scratch");
    stage_.status_["own"] = ResultPaths(old_manifest_, old_status_);
    if (old_manifest_.is_object()) {
      stage_.remove_earlier_result_ = [this] { RemoveEarlierRun(); };
    } else {
      RemoveEarlierRun();
    }
  }
  WriteJson(request.folder / kStatusFile, stage_.status_);
  StartLog();
}

std::string StageRun::WhyNotResumed() const {
  const json& earlier = old_manifest_.is_object() ? old_manifest_ : old_status_;
  if (!earlier.is_object()) return "there is no earlier run in this folder; leave out --resume";
  if (earlier.value("key", "") == stage_.key_) {
    return "the earlier run was finished, and its output was changed since; leave out --resume, to "
           "start over";
  }
  return fmt::format(
      "the earlier run in this folder differs in {}; give the same options and input again, or do "
      "not resume, to start over",
      DifferenceOf(earlier, request_.options_with_effect));
}

// Its part of the log goes, too; what this run has written behind it stays.
void StageRun::RemoveEarlierRun() {
  // No run may continue what is half removed.
  stage_.status_["key"] = "";
  WriteJson(request_.folder / kStatusFile, stage_.status_);
  RemoveOldRun(request_.folder, old_manifest_, old_status_);
  stage_.RemoveEarlierCaches();
  stage_.status_["own"] = json::array();
  stage_.status_["key"] = stage_.key_;
  const fs::path log = request_.folder / kLogFileName;
  if (log_begin_ == 0) return RemoveOwned(log);
  SetLogFile({});
  const std::string text = ReadText(log);
  WriteText(log, text.substr(std::min<size_t>(log_begin_, text.size())));
  SetLogFile(log);
}

void StageRun::StartLog() {
  const fs::path log = request_.folder / kLogFileName;
  std::error_code error;
  if (!stage_.resume_ && fs::exists(log, error)) log_begin_ = fs::file_size(log, error);
  SetLogFile(log);
  LogToFileOnly(fmt::format("{} {} ({}), version {}", ProgramOf(request_.stage), ProgramVersion(),
                            GitRevision(), request_.version));
  LogToFileOnly("command: " + request_.command_line);
  LogToFileOnly("options: " +
                request_.options.dump(-1, ' ', false, json::error_handler_t::replace));
  if (stage_.resume_) {
    LogInfo("{}: continues an earlier run ({})", request_.folder.string(),
            StateInWords(old_status_));
  }
}

void StageRun::Call(const std::function<void(Stage&)>& body) {
  try {
    body(stage_);
    Finish();
  } catch (const Interrupted& error) {
    RecordFailure("interrupted", error.what());
    throw;
  } catch (const std::bad_alloc&) {
    RecordFailure("failed", "out of memory");
    throw;
  } catch (const std::exception& error) {
    RecordFailure("failed", OneLine(error.what()));
    throw;
  }
  // The result is whole, but whoever asked for a stop wants no further stage.
  ThrowIfStopRequested("the result was finished before");
}

void StageRun::RecordFailure(const char* state, const std::string& message) {
  stage_.status_["status"] = state;
  stage_.status_["error"] = message;
  stage_.status_["seconds"] = stage_.TotalSeconds();
  LogToFileOnly("error: " + message);
  try {
    if (stage_.remove_earlier_result_ && old_status_.is_object()) KeepEarlierResult();
    WriteJson(request_.folder / kStatusFile, stage_.status_);
  } catch (const Error&) {
    // The disk may be full; the first error is the one to report.
  }
}

void StageRun::KeepEarlierResult() {
  LogToFileOnly("the earlier result stays as it is");
  RemoveDeclared(request_.folder, stage_.status_, "scratch");
  json earlier = StatusOfResult(old_manifest_, old_status_);
  earlier["caches"] = stage_.status_["caches"];
  stage_.status_ = earlier;
}

void StageRun::Finish() {
  stage_.RemoveEarlierResult();
  RemoveDeclared(request_.folder, stage_.status_, "scratch");  // of earlier attempts, too
  const double seconds = stage_.TotalSeconds();
  stage_.seconds_["total"] = seconds;
  ManifestFacts facts = {.stage = request_.stage,
                         .version = request_.version,
                         .key = stage_.key_,
                         .command = request_.command_line,
                         .options = request_.options,
                         .inputs = json::array(),
                         .outputs = OutputRecords(request_.folder, stage_.outputs_),
                         .device = stage_.device_,
                         .counts = stage_.counts_,
                         .notes = stage_.notes_,
                         .seconds = stage_.seconds_,
                         .warnings = TakeWarnings(),
                         .degraded = stage_.degraded_,
                         .resumed = stage_.resume_};
  for (const StageInput& input : request_.inputs) facts.inputs.push_back(input.record);
  LogWarningsAgain(facts.warnings);
  stage_.status_["status"] = "done";
  stage_.status_["seconds"] = seconds;
  WriteJson(request_.folder / kStatusFile, stage_.status_);
  LogInfo("done in {}: {}", AsDuration(seconds), request_.folder.string());
  WriteManifest(request_.folder, facts);
}

std::string StageRequest::Key() const {
  json hashes = json::object();
  for (const StageInput& input : inputs) {
    for (const auto& [name, hash] : input.hashes) hashes[name] = hash;
  }
  return HashOfJson({{"stage", stage},
                     {"version", version},
                     {"options", options_with_effect},
                     {"inputs", hashes}});
}

void RunStage(const StageRequest& request, const std::function<void(Stage&)>& body) {
  CheckPathIsText(request.folder);
  std::error_code error;
  fs::create_directories(request.folder, error);
  if (error) {
    throw EnvironmentError(fmt::format("{}: the output folder cannot be made ({})",
                                       request.folder.string(), error.message()));
  }
  CheckFolderIsOurs(request.folder, request.stage);
  const json manifest = ReadManifestOrStatus(request.folder / kManifestFile);
  const bool is_same = manifest.is_object() && manifest["key"] == request.Key();
  const bool is_whole =
      is_same && (request.resume || manifest.value("degraded", json::array()).empty());
  if (is_whole && !request.force && FirstSpoiledOutput(request.folder, manifest).empty()) {
    TidyUp(request.folder, manifest);
    fmt::print("up to date: {}\n", request.folder.string());
    return;
  }
  const FolderLock lock(request.folder);
  RefuseLinks(request.folder, ReadManifestOrStatus(request.folder / kStatusFile));
  StageRun(request).Call(body);
}

}  // namespace tetrec
