// From a command line to a StageRequest.
#include "command/stage_command.h"

#include "command/option_values.h"
#include "command/run_command.h"
#include "core/error.h"
#include "core/manifest.h"
#include "core/stage_run.h"
#include "core/stop_request.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

namespace tetrec {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

std::string WithoutDashes(const std::string& name) {
  const size_t start = name.find_first_not_of('-');
  return start == std::string::npos ? name : name.substr(start);
}

// Without slashes at its end; "." and ".." stay what they are.
fs::path FolderOf(const fs::path& output) {
  const fs::path folder = (output / "").lexically_normal();
  return folder.has_filename() ? folder : folder.parent_path();
}

// The argument as it can be pasted into a shell.
std::string QuotedForShell(const std::string& argument) {
  const bool plain = !argument.empty() && std::all_of(argument.begin(), argument.end(), [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || std::strchr("_-./:=,+@%", c) != nullptr;
  });
  if (plain) return argument;
  std::string quoted = "'";
  for (const char c : argument) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

}  // namespace

StageCommand::StageCommand(std::string name, int version, const std::string& description)
    : name_(std::move(name)), version_(version), app_(description, ProgramOf(name_)) {
  app_.option_defaults()->always_capture_default();
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

void StageCommand::AlsoHash(const std::string& input_name, FilesNamedBy files_of) {
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

StageRequest StageCommand::MakeRequest(int argc, char** argv) const {
  StageRequest request = {.stage = name_,
                          .version = version_,
                          .folder = FolderOf(output_),
                          .options = Options(false),
                          .options_with_effect = Options(true),
                          .command_line = ProgramOf(name_),
                          .resume = resume_,
                          .force = force_};
  for (const auto& input : inputs_) {
    if (input->option->count() == 0) continue;
    request.inputs.push_back(
        ReadStageInput(input->name, input->path, input->stages, request.folder, input->files_of));
  }
  for (int i = 1; i < argc; ++i) request.command_line += " " + QuotedForShell(argv[i]);
  return request;
}

int StageCommand::Run(int argc, char** argv, const std::function<void(Stage&)>& body,
                      const std::function<void()>& check_options) {
  app_.option_defaults()->group("Folder to write");
  app_.add_option("-o,--output", output_, "Folder to write; created if it does not exist")
      ->required()
      ->type_name("FOLDER")
      ->default_str("");
  auto* resume =
      app_.add_flag("--resume", resume_,
                    "Fail unless an earlier run with the same options is finished or can be "
                    "continued");
  app_.add_flag("--force", force_,
                "Start over, even if the folder is up to date or could be resumed")
      ->excludes(resume);
  return RunCommand(app_, argc, argv, [&] {
    if (check_options) CheckOptions(app_, check_options);
    CatchStopSignals();
    RunStage(MakeRequest(argc, argv), body);
  });
}

}  // namespace tetrec
