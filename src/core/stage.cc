// A stage's command line, key, folder, status and manifest.
#include "core/stage.h"

#include "core/error.h"
#include "core/file.h"
#include "core/folder_lock.h"
#include "core/log.h"
#include "core/option_values.h"
#include "core/progress.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstring>
#include <ctime>

namespace tetrec {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

constexpr int kSchema = 1;
constexpr const char* kManifest = "manifest.json";
constexpr const char* kStatus = "status.json";
constexpr const char* kLog = "log.txt";

volatile std::sig_atomic_t stop_signal = 0;

extern "C" void OnStopSignal(int number) {
  if (stop_signal != 0) _exit(130);
  stop_signal = number;
}

void CatchStopSignals() {
  struct sigaction action {};
  action.sa_handler = OnStopSignal;
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  std::signal(SIGPIPE, SIG_IGN);  // a closed terminal or pipe must not end hours of work
}

std::string Program(const std::string& stage) { return "tetrec-" + stage; }

std::string ProgramsOf(const std::set<std::string>& stages) {
  std::vector<std::string> names;
  for (const std::string& stage : stages) names.push_back(Program(stage));
  return fmt::format("{}", fmt::join(names, " or "));
}

std::string NowUtc() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof(text), "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

std::string OneLine(std::string text) {
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back()))) text.pop_back();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

// As it can be pasted into a shell.
std::string QuotedForShell(const std::string& argument) {
  const bool plain = !argument.empty() && std::all_of(argument.begin(), argument.end(), [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || std::strchr("_-./:=,+@%", c) != nullptr;
  });
  if (plain) return argument;
  std::string quoted = "'";
  for (const char c : argument) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

std::string HashOfJson(const json& value) {
  const std::string text = value.dump(-1, ' ', false, json::error_handler_t::replace);
  return Sha256({reinterpret_cast<const uint8_t*>(text.data()), text.size()});
}

// manifest.json or status.json where it exists and a stage wrote it; null else.
json ReadOwnJson(const fs::path& path) {
  std::error_code error;
  if (!fs::exists(path, error)) return nullptr;
  try {
    json value = ReadJson(path);
    const bool ours = value.is_object() && value.contains("schema") &&
                      value["schema"].is_number_integer() && value.contains("stage") &&
                      value["stage"].is_string() && value.contains("key") &&
                      value["key"].is_string();
    return ours ? value : nullptr;
  } catch (const DataError&) {
    return nullptr;
  }
}

std::string TextOr(const json& object, const char* field, const std::string& otherwise) {
  const auto found = object.find(field);
  return found != object.end() && found->is_string() ? found->get<std::string>() : otherwise;
}

// Empty, or the first listed output that is gone or has another size.
std::string FirstSpoiledOutput(const fs::path& folder, const json& manifest) {
  const auto outputs = manifest.find("outputs");
  if (outputs == manifest.end() || !outputs->is_array()) return kManifest;
  for (const json& output : *outputs) {
    const std::string path = output.is_object() ? TextOr(output, "path", "") : "";
    const auto bytes = output.is_object() ? output.find("bytes") : output.end();
    if (path.empty() || bytes == output.end() || !bytes->is_number_unsigned()) return kManifest;
    std::error_code error;
    if (fs::file_size(folder / path, error) != bytes->get<uint64_t>() || error) return path;
  }
  return "";
}

// Names, sizes and times of the files inside: enough to see a change without reading gigabytes.
// Links to folders are followed, but none to where the listing has been: they may lead in circles.
json ListingOf(const fs::path& folder) {
  json listing = json::array();
  std::set<fs::path> entered = {fs::canonical(folder)};
  std::error_code error;
  fs::recursive_directory_iterator entry(folder, fs::directory_options::follow_directory_symlink,
                                         error);
  for (; !error && entry != fs::recursive_directory_iterator(); entry.increment(error)) {
    std::error_code gone;
    if (entry->is_directory(gone) && !entered.insert(fs::canonical(entry->path())).second) {
      entry.disable_recursion_pending();
    }
    if (!entry->is_regular_file(gone)) continue;
    listing.push_back({entry->path().lexically_relative(folder).string(), entry->file_size(),
                       int64_t(entry->last_write_time().time_since_epoch().count())});
  }
  if (error) {
    throw DataError(fmt::format("{}: cannot be listed ({})", folder.string(), error.message()));
  }
  std::sort(listing.begin(), listing.end());
  return listing;
}

bool IsInside(const fs::path& inner, const fs::path& outer) {
  const fs::path relative = fs::weakly_canonical(fs::absolute(inner))
                                .lexically_relative(fs::weakly_canonical(fs::absolute(outer)));
  return !relative.empty() && *relative.begin() != "..";
}

std::string RelativeTo(const fs::path& path, const fs::path& folder) {
  // Absolute first: a relative path of which nothing exists yet stays relative when made canonical.
  return fs::weakly_canonical(fs::absolute(path))
      .lexically_relative(fs::weakly_canonical(fs::absolute(folder)))
      .generic_string();
}

void RemoveOwned(const fs::path& path) {
  std::error_code error;
  for (const fs::path& victim : {path, fs::path(path.string() + ".tmp")}) {
    fs::remove_all(victim, error);
    if (error) {
      throw EnvironmentError(
          fmt::format("{}: cannot be removed ({})", victim.string(), error.message()));
    }
  }
}

// A path of our own folder as a file gives it: no way out of the folder, nor all of it.
bool StaysInFolder(const fs::path& path) {
  if (path.empty() || path.is_absolute()) return false;
  return std::none_of(path.begin(), path.end(),
                      [](const fs::path& part) { return part == "." || part == ".."; });
}

// What an earlier run declared in this role: "own" (top names of outputs), "scratch" or "caches".
std::set<std::string> DeclaredPaths(const json& status, const char* role) {
  std::set<std::string> paths;
  const auto list = status.is_object() ? status.find(role) : status.end();
  if (!status.is_object() || list == status.end() || !list->is_array()) return paths;
  for (const json& path : *list) {
    if (path.is_string() && StaysInFolder(path.get<std::string>()))
      paths.insert(path.get<std::string>());
  }
  return paths;
}

void RemoveOldRun(const fs::path& folder, const json& manifest, const json& status,
                  bool caches_too) {
  std::set<std::string> paths = DeclaredPaths(status, "own");
  paths.merge(DeclaredPaths(status, "scratch"));
  if (manifest.is_object() && manifest.contains("outputs") && manifest["outputs"].is_array()) {
    for (const json& output : manifest["outputs"]) {
      const fs::path path = output.is_object() ? TextOr(output, "path", "") : "";
      if (StaysInFolder(path)) paths.insert(path.begin()->string());
    }
  }
  if (caches_too) paths.merge(DeclaredPaths(status, "caches"));
  RemoveOwned(folder / kManifest);  // first: a half-removed folder must not look finished
  for (const std::string& path : paths) RemoveOwned(folder / path);
  RemoveOwned(folder / kLog);
}

// What makes the key differ, in words. `now` holds only options that change results.
std::string DifferenceOf(const json& before, const json& now) {
  const json old = before.value("options", json::object());
  std::vector<std::string> parts;
  for (const auto& [name, value] : now.items()) {
    const std::string was = old.contains(name) ? old[name].dump() : "not known";
    if (was != value.dump())
      parts.push_back(fmt::format("--{} (was {}, now {})", name, was, value.dump()));
  }
  if (parts.empty()) return "the input or the program's version";
  return fmt::format("{}", fmt::join(parts, ", "));
}

bool IsAlive(const json& status) {
  const auto pid = status.find("pid");
  return pid != status.end() && pid->is_number_integer() && pid->get<int64_t>() > 0 &&
         kill(pid_t(pid->get<int64_t>()), 0) == 0;
}

// `may_run` is false for who holds the folder's lock: the process id may be another's by now.
std::string StateInWords(const json& status, bool may_run) {
  const std::string state = TextOr(status, "status", "unfinished");
  if (state == "running")
    return may_run && IsAlive(status) ? "is still running" : "was killed before it finished";
  const std::string error = TextOr(status, "error", "");
  return state + (error.empty() ? "" : ": " + error);
}

uint64_t PeakRssBytes() {
  uint64_t peak = 0;
  for (const int who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage usage{};
    getrusage(who, &usage);
    peak = std::max(peak, uint64_t(usage.ru_maxrss) * 1024);
  }
  return peak;
}

json FileRecord(const fs::path& folder, const fs::path& file) {
  return {{"path", file.lexically_relative(folder).generic_string()},
          {"bytes", fs::file_size(file)},
          {"sha256", Sha256OfFile(file)}};
}

json OutputRecords(const fs::path& folder, const std::set<std::string>& outputs) {
  std::set<fs::path> files;
  for (const std::string& relative : outputs) {
    const fs::path path = folder / relative;
    if (fs::is_directory(path)) {
      for (const auto& entry : fs::recursive_directory_iterator(path)) {
        if (entry.is_regular_file() && entry.path().extension() != ".tmp")
          files.insert(entry.path());
      }
    } else {
      TETREC_CHECK(fs::is_regular_file(path), "the stage did not write its output " + relative);
      files.insert(path);
    }
  }
  json records = json::array();
  for (const fs::path& file : files) records.push_back(FileRecord(folder, file));
  return records;
}

bool IsForeign(const fs::path& folder) {
  if (!ReadOwnJson(folder / kManifest).is_null() || !ReadOwnJson(folder / kStatus).is_null())
    return false;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename();
    // A run that was killed at its very start leaves no more than these.
    if (name != kLockFile && name != std::string(kStatus) + ".tmp") return true;
  }
  return false;
}

std::string WithoutDashes(const std::string& name) {
  const size_t start = name.find_first_not_of('-');
  return start == std::string::npos ? name : name.substr(start);
}

}  // namespace

bool StopRequested() { return stop_signal != 0; }

void ThrowIfStopRequested(const std::string& saved) {
  if (StopRequested()) throw Interrupted("stopped by the user; " + saved);
}

json ReadManifest(const fs::path& folder, const std::set<std::string>& stages) {
  const std::string name = folder.string(), programs = ProgramsOf(stages);
  std::error_code error;
  if (!fs::is_directory(folder, error)) {
    throw DataError(
        fmt::format("{}: there is no such folder; run {} with -o {} first", name, programs, name));
  }
  const json manifest = ReadOwnJson(folder / kManifest), status = ReadOwnJson(folder / kStatus);
  if (manifest.is_null() && status.is_null()) {
    throw DataError(
        fmt::format("{}: is not a stage folder (no valid manifest.json in it); expected the folder "
                    "that {} wrote",
                    name, programs));
  }
  const json& known = manifest.is_null() ? status : manifest;
  const std::string stage = known["stage"];
  if (!stages.contains(stage)) {
    throw DataError(fmt::format("{}: is the folder of {}; expected the folder that {} wrote", name,
                                Program(stage), programs));
  }
  if (manifest.is_null()) {
    throw DataError(fmt::format("{}: {} did not finish there ({}); run it again", name,
                                Program(stage), StateInWords(status, true)));
  }
  if (manifest["schema"] != kSchema) {
    throw DataError(fmt::format("{}: manifest.json has the schema {}, known is {}; run {} again",
                                name, manifest["schema"].dump(), kSchema, Program(stage)));
  }
  if (const std::string spoiled = FirstSpoiledOutput(folder, manifest); !spoiled.empty()) {
    throw DataError(fmt::format("{}: {} is missing or was changed; run {} again", name, spoiled,
                                Program(stage)));
  }
  return manifest;
}

fs::path PreviousStage(const fs::path& folder, const std::set<std::string>& stages) {
  constexpr int kLongestChain = 16;  // manifests come from outside: they may point in a circle
  fs::path at = folder;
  for (int link = 0;; ++link) {
    const json manifest = ReadOwnJson(at / kManifest);
    if (link == kLongestChain || !manifest.is_object() || !manifest.contains("previous") ||
        !manifest["previous"].is_string()) {
      throw DataError(
          fmt::format("{}: is not the folder of {} that {} was made from; put it back there or run "
                      "the stages again",
                      at.string(), ProgramsOf(stages), folder.string()));
    }
    at = (at / manifest["previous"].get<std::string>()).lexically_normal();
    const json before = ReadOwnJson(at / kManifest);
    if (before.is_object() && before.contains("stage") && before["stage"].is_string() &&
        stages.contains(before["stage"].get<std::string>())) {
      ReadManifest(at, stages);
      return at;
    }
  }
}

fs::path Stage::Input(const std::string& name) const {
  TETREC_CHECK(HasInput(name), "no input named " + name);
  return inputs_.at(WithoutDashes(name));
}

bool Stage::HasInput(const std::string& name) const {
  return inputs_.contains(WithoutDashes(name));
}

const json& Stage::InputManifest(const std::string& name) const {
  TETREC_CHECK(input_manifests_.contains(WithoutDashes(name)), "no stage input named " + name);
  return input_manifests_.at(WithoutDashes(name));
}

fs::path Stage::Declare(const std::string& relative, const char* role, bool by_top_name) {
  const fs::path path = fs::path(relative).lexically_normal();
  TETREC_CHECK(StaysInFolder(path), "not a path inside the stage folder: " + relative);
  const json name = by_top_name ? path.begin()->string() : path.string();
  json& names = status_[role];
  if (std::find(names.begin(), names.end(), name) == names.end()) {
    names.push_back(name);
    WriteJson(folder_ / kStatus, status_);
  }
  const fs::path parent = (folder_ / path).parent_path();
  std::error_code error;
  fs::create_directories(parent, error);
  if (error)
    throw EnvironmentError(
        fmt::format("{}: cannot be made ({})", parent.string(), error.message()));
  return folder_ / path;
}

fs::path Stage::Output(const std::string& relative) {
  outputs_.insert(relative);
  return Declare(relative, "own", true);
}

fs::path Stage::Scratch(const std::string& relative) { return Declare(relative, "scratch", false); }

fs::path Stage::Cache(const std::string& relative) { return Declare(relative, "caches", true); }

struct StageCommand::Request {
  fs::path folder;
  std::string key;
  json options, options_with_effect, input_records = json::array();
  std::map<std::string, fs::path> inputs;
  std::map<std::string, json> manifests;
};

StageCommand::StageCommand(std::string name, int version, const std::string& description)
    : name_(std::move(name)), version_(version), app_(description, Program(name_)) {
  app_.option_defaults()->always_capture_default();
  app_.set_version_flag("--version",
                        fmt::format("{} {} ({})", Program(name_), TETREC_VERSION, TETREC_GIT));
}

void StageCommand::InputStage(const std::string& name, const std::string& help,
                              std::set<std::string> stages, bool required) {
  TETREC_CHECK(!stages.empty(), "an input stage needs the names of its stages");
  InputPath(name, help, required);
  inputs_.back()->stages = std::move(stages);
}

void StageCommand::InputPath(const std::string& name, const std::string& help, bool required) {
  auto input = std::make_unique<InputSpec>();
  input->name = WithoutDashes(name);
  input->option = app_.add_option(name, input->path, help)->required(required);
  input->option->type_name("PATH")->default_str("");
  inputs_.push_back(std::move(input));
}

void StageCommand::FilesNamedBy(const std::string& input_name,
                                std::function<std::vector<fs::path>(const fs::path&)> files_of) {
  const auto input = std::find_if(inputs_.begin(), inputs_.end(), [&](const auto& i) {
    return i->name == WithoutDashes(input_name);
  });
  TETREC_CHECK(input != inputs_.end(), "no input named " + input_name);
  (*input)->files_of = std::move(files_of);
}

void StageCommand::DoesNotChangeResults(CLI::Option* option) { without_effect_.insert(option); }

json StageCommand::Options(bool with_effect_only) const {
  std::set<std::string> skipped = {"help", "version", "output", "resume", "force"};
  json options = json::object();
  for (const CLI::Option* option : app_.get_options()) {
    const std::string name = WithoutDashes(option->get_single_name());
    const bool input = std::any_of(inputs_.begin(), inputs_.end(),
                                   [&](const auto& i) { return i->option == option; });
    if (input || skipped.contains(name) || (with_effect_only && without_effect_.contains(option)))
      continue;
    options[name] = OptionValue(*option);
  }
  return options;
}

StageCommand::Request StageCommand::MakeRequest() const {
  Request request;
  request.folder = (output_ / "").lexically_normal().parent_path();
  request.options = Options(false);
  request.options_with_effect = Options(true);
  json keys = json::object();
  for (const auto& input : inputs_) {
    if (input->option->count() == 0) continue;
    const fs::path& path = input->path;
    json record = {{"name", input->name}, {"path", RelativeTo(path, request.folder)}};
    if (!input->stages.empty()) {
      json manifest = ReadManifest(path, input->stages);
      if (IsInside(request.folder, path)) {
        throw UsageError(
            fmt::format("the output folder {} lies in the input folder {}; choose another",
                        request.folder.string(), path.string()));
      }
      record["kind"] = "stage";
      record["stage"] = manifest["stage"];
      record["sha256"] = HashOfJson(manifest["outputs"]);
      request.manifests[input->name] = std::move(manifest);
    } else if (fs::is_directory(path)) {
      if (IsInside(request.folder, path)) {
        throw UsageError(
            fmt::format("the output folder {} lies in the input folder {}; choose another",
                        request.folder.string(), path.string()));
      }
      record["kind"] = "folder";
      record["sha256"] = HashOfJson(ListingOf(path));
    } else if (fs::is_regular_file(path)) {
      record["kind"] = "file";
      record["sha256"] = Sha256OfFile(path);
      json named = json::array();
      if (input->files_of) {
        for (const fs::path& file : input->files_of(path)) {
          named.push_back(
              {{"path", RelativeTo(file, request.folder)}, {"sha256", Sha256OfFile(file)}});
          keys[input->name + " names " + file.filename().string()] = named.back()["sha256"];
        }
      }
      if (!named.empty()) record["names"] = named;
    } else {
      throw DataError(fmt::format("{}: there is no such file or folder", path.string()));
    }
    keys[input->name] = record["sha256"];
    request.inputs[input->name] = path;
    request.input_records.push_back(std::move(record));
  }
  request.key = HashOfJson({{"stage", name_},
                            {"version", version_},
                            {"options", request.options_with_effect},
                            {"inputs", keys}});
  return request;
}

void StageCommand::Finish(Stage& stage, const Request& request, double seconds) {
  // Scratch of the attempts before this one too.
  for (const std::string& path : DeclaredPaths(stage.status_, "scratch"))
    RemoveOwned(stage.folder_ / path);
  const std::vector<std::string> warnings = TakeWarnings();
  if (!warnings.empty()) {
    LogLine(LogLevel::kInfo,
            fmt::format("{} warning{}:", warnings.size(), warnings.size() == 1 ? "" : "s"));
    for (const std::string& warning : warnings) LogLine(LogLevel::kInfo, "  " + warning);
  }
  stage.seconds_["total"] = seconds;
  json manifest = {{"schema", kSchema},
                   {"stage", name_},
                   {"version", version_},
                   {"program_version", TETREC_VERSION},
                   {"git", TETREC_GIT},
                   {"key", request.key},
                   {"command", stage.status_["command"]},
                   {"options", request.options},
                   {"seed", request.options.contains("seed") ? request.options["seed"] : json()},
                   {"inputs", request.input_records},
                   {"previous", nullptr},
                   {"outputs", OutputRecords(stage.folder_, stage.outputs_)},
                   {"device", stage.device_},
                   {"counts", stage.counts_},
                   {"notes", stage.notes_},
                   {"warnings", warnings},
                   {"seconds", stage.seconds_},
                   {"resumed", stage.resume_},
                   {"peak_rss_bytes", PeakRssBytes()},
                   {"finished", NowUtc()}};
  for (const json& input : request.input_records) {
    if (input["kind"] == "stage" && manifest["previous"].is_null())
      manifest["previous"] = input["path"];
  }
  stage.status_["status"] = "done";
  stage.status_["seconds"] = seconds;
  WriteJson(stage.folder_ / kStatus, stage.status_);
  LogInfo("done in {}: {}", AsDuration(seconds), stage.folder_.string());
  WriteJson(stage.folder_ / kManifest, manifest);
}

void StageCommand::RunLocked(const Request& request, const std::string& command_line,
                             const std::function<void(Stage&)>& body) {
  const Timer timer;
  const json manifest = ReadOwnJson(request.folder / kManifest),
             status = ReadOwnJson(request.folder / kStatus);
  const bool same_key = status.is_object() && status["key"] == request.key && manifest.is_null();
  if (resume_ && !same_key && (status.is_object() || manifest.is_object())) {
    throw DataError(fmt::format(
        "{}: cannot resume, another run stands there: different is {}; give the earlier "
        "options and input, or leave --resume away to start over",
        request.folder.string(),
        DifferenceOf(manifest.is_object() ? manifest : status, request.options_with_effect)));
  }

  Stage stage;
  stage.folder_ = request.folder;
  stage.inputs_ = request.inputs;
  stage.input_manifests_ = request.manifests;
  stage.key_ = request.key;
  stage.resume_ = same_key && !force_;
  stage.status_ = {{"schema", kSchema},          {"stage", name_},
                   {"status", "running"},        {"key", request.key},
                   {"options", request.options}, {"pid", getpid()},
                   {"started", NowUtc()},        {"error", nullptr},
                   {"own", json::array()},       {"scratch", json::array()},
                   {"caches", json::array()}};
  stage.status_["command"] = command_line;
  double seconds_before = 0;
  if (stage.resume_) {
    for (const char* role : {"own", "scratch"}) stage.status_[role] = DeclaredPaths(status, role);
    if (status.contains("seconds") && status["seconds"].is_number())
      seconds_before = status["seconds"];
  } else {
    RemoveOldRun(request.folder, manifest, status, force_);
  }
  if (!force_) stage.status_["caches"] = DeclaredPaths(status, "caches");
  WriteJson(request.folder / kStatus, stage.status_);

  SetLogFile(request.folder / kLog);
  LogToFileOnly(
      fmt::format("{} {} ({}), version {}", Program(name_), TETREC_VERSION, TETREC_GIT, version_));
  LogToFileOnly("command: " + command_line);
  LogToFileOnly("options: " + request.options.dump(-1, ' ', false, json::error_handler_t::replace));
  if (stage.resume_) {
    LogInfo("{}: goes on where an earlier run ended ({})", request.folder.string(),
            StateInWords(status, false));
  }

  const auto record_failure = [&](const char* state, const std::string& message) {
    stage.status_["status"] = state;
    stage.status_["error"] = message;
    stage.status_["seconds"] = seconds_before + timer.seconds();
    LogToFileOnly("error: " + message);
    try {
      WriteJson(request.folder / kStatus, stage.status_);
    } catch (const Error&) {
      // The disk may be full; the first error is the one to tell.
    }
  };
  try {
    body(stage);
    ThrowIfStopRequested("run the same command again to go on");
    Finish(stage, request, seconds_before + timer.seconds());
  } catch (const Interrupted& error) {
    record_failure("interrupted", error.what());
    throw;
  } catch (const std::bad_alloc&) {
    record_failure("failed", "out of memory");
    throw;
  } catch (const std::exception& error) {
    record_failure("failed", OneLine(error.what()));
    throw;
  }
}

int StageCommand::Run(int argc, char** argv, const std::function<void(Stage&)>& body,
                      const std::function<void()>& check_options) {
  const std::string program = Program(name_);
  const auto fail = [&](const std::string& message, int code) {
    SetStatusLine("");
    fmt::print(stderr, "{}: {}\n", program, OneLine(message));
    return code;
  };
  try {
    app_.add_option("-o,--output", output_, "Folder to write; made where it does not exist")
        ->required()
        ->type_name("FOLDER")
        ->default_str("");
    auto* resume = app_.add_flag("--resume", resume_,
                                 "Fail unless an earlier run of the same options can be continued");
    app_.add_flag("--force", force_,
                  "Start over, even where the folder is up to date or could be resumed")
        ->excludes(resume);
    app_.parse(argc, argv);
    CheckNumbers(app_);
    if (check_options) check_options();
    CatchStopSignals();

    const Request request = MakeRequest();
    std::error_code error;
    fs::create_directories(request.folder, error);
    if (error) {
      throw EnvironmentError(fmt::format("{}: the output folder cannot be made ({})",
                                         request.folder.string(), error.message()));
    }
    if (IsForeign(request.folder)) {
      throw UsageError(fmt::format("{} is not empty and not a stage folder; choose another",
                                   request.folder.string()));
    }
    for (const char* file : {kManifest, kStatus}) {
      const json old = ReadOwnJson(request.folder / file);
      if (old.is_object() && old["stage"] != name_) {
        throw UsageError(fmt::format("{} is the folder of {}; choose another",
                                     request.folder.string(),
                                     Program(old["stage"].get<std::string>())));
      }
    }
    const json manifest = ReadOwnJson(request.folder / kManifest);
    if (!force_ && manifest.is_object() && manifest["key"] == request.key &&
        FirstSpoiledOutput(request.folder, manifest).empty()) {
      fmt::print("up to date: {}\n", request.folder.string());
      return 0;
    }
    const FolderLock lock(request.folder);
    std::string command_line = program;
    for (int i = 1; i < argc; ++i) command_line += " " + QuotedForShell(argv[i]);
    RunLocked(request, command_line, body);
    return 0;
  } catch (const CLI::CallForHelp&) {
    fmt::print("{}", app_.help());
    return 0;
  } catch (const CLI::CallForVersion& version) {
    fmt::print("{}\n", version.what());
    return 0;
  } catch (const CLI::ParseError& error) {
    return fail(std::string(error.what()) + " (see --help)", 2);
  } catch (const Error& error) {
    return fail(error.what(), error.exit_code());
  } catch (const std::bad_alloc&) {
    return fail("out of memory; use smaller pictures or a smaller mesh", 4);
  } catch (const fs::filesystem_error& error) {
    return fail(error.what(), 4);
  } catch (const std::exception& error) {
    return fail(std::string("bug: ") + error.what(), 1);
  }
}

}  // namespace tetrec
