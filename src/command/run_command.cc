// Errors to lines and exit codes.
#include "command/run_command.h"

#include "command/help.h"
#include "command/option_values.h"
#include "core/error.h"
#include "core/log.h"
#include "core/process_memory.h"
#include "core/version.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <memory>
#include <new>
#include <regex>
#include <string_view>
#include <system_error>

namespace tetrec {
namespace {

// A file that is opened while one of the standard streams is closed would take its place and
// receive its messages.
void OpenStandardStreams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(stream, F_GETFD) < 0) open("/dev/null", O_RDWR);  // takes the lowest free number
  }
}

void AddVersion(CLI::App& app) {
  app.option_defaults()->group("Options");
  app.set_version_flag("--version",
                       fmt::format("{} {} ({})", app.get_name(), ProgramVersion(), GitRevision()));
}

// What the standard library found at a path that was given or that a file names.
Error ErrorOf(const std::filesystem::filesystem_error& error) {
  const std::string message = fmt::format("{}: {}", error.path1().string(), error.code().message());
  const auto is = [&](std::errc code) { return error.code() == code; };
  const bool is_name = is(std::errc::filename_too_long) || is(std::errc::not_a_directory) ||
                       is(std::errc::too_many_symbolic_link_levels);
  if (is_name) return UsageError(message + "; give another path");
  return EnvironmentError(message);
}

// OpenCV mentions a lack of memory only in its text.
bool IsOpenCvWithoutMemory(const std::exception& error) {
  const std::string_view text = error.what();
  return text.find("OpenCV") != text.npos && text.find("Insufficient memory") != text.npos;
}

// For options that the program does not have, the one that may be meant.
std::string HintFor(const CLI::App& app, int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i], name = word.substr(0, word.find('='));
    if (!word.starts_with("--") || app.get_option_no_throw(name) != nullptr) continue;
    if (const std::string nearest = NearestOption(app, word); !nearest.empty())
      return fmt::format("; did you mean {}? (see --help)", nearest);
  }
  return " (see --help)";
}

}  // namespace

int RunCommand(CLI::App& app, int argc, char** argv, const std::function<void()>& body) {
  const auto fail = [&](const std::string& message, int code) {
    SetStatusLine("");
    fmt::print(stderr, "{}: {}\n", app.get_name(), OneLine(message));
    return code;
  };
  const auto fail_by_memory = [&] {
    return fail("out of memory; use smaller pictures or a smaller mesh", 4);
  };
  app.formatter(std::make_shared<HelpFormatter>());
  AddVersion(app);
  OpenStandardStreams();
  ReturnLargeBlocksWhenFreed();
  std::signal(SIGXFSZ, SIG_IGN);  // a file that grows too large is an error of the write
  try {
    app.parse(argc, argv);
    CheckNumbers(app);
    body();
    return 0;
  } catch (const CLI::CallForHelp&) {
    fmt::print("{}", app.help());
    return 0;
  } catch (const CLI::CallForVersion& version) {
    fmt::print("{}\n", version.what());
    return 0;
  } catch (const CLI::ConversionError& error) {
    return fail(
        fmt::format("{}; expected a number in range, without a unit (see --help)", error.what()),
        2);
  } catch (const CLI::ParseError& error) {
    return fail(error.what() + HintFor(app, argc, argv), 2);
  } catch (const Error& error) {
    return fail(error.what(), error.exit_code());
  } catch (const std::bad_alloc&) {
    return fail_by_memory();
  } catch (const std::filesystem::filesystem_error& error) {
    return fail(ErrorOf(error).what(), ErrorOf(error).exit_code());
  } catch (const std::system_error& error) {
    if (error.code() == std::errc::resource_unavailable_try_again) {
      return fail(
          "the system starts no more threads or processes; end other programs or raise the limit "
          "(ulimit -u)",
          4);
    }
    return fail(fmt::format("the system refuses: {}", error.what()), 4);
  } catch (const std::exception& error) {
    if (IsOpenCvWithoutMemory(error)) return fail_by_memory();
    return fail(std::string("bug: ") + error.what(), 1);
  }
}

namespace {

// "--max-size" for "max_size", or "" where the program has no such option.
std::string OptionName(const CLI::App& app, const std::string& word) {
  std::string option = "--" + word;
  std::replace(option.begin(), option.end(), '_', '-');
  return app.get_option_no_throw(option) == nullptr ? "" : option;
}

}  // namespace

void CheckOptions(const CLI::App& app, const std::function<void()>& check) {
  try {
    check();
  } catch (const UsageError& error) {
    static const std::regex kName("^[-a-z_0-9]+(?=[ :])|'([a-z_0-9]+)'");
    const std::string message = error.what();
    std::string translated;
    auto rest = message.cbegin();
    for (std::sregex_iterator name(message.begin(), message.end(), kName), end; name != end;
         ++name) {
      const std::string option = OptionName(app, (*name)[1].matched ? name->str(1) : name->str(0));
      translated.append(rest, (*name)[0].first);
      translated += option.empty() ? name->str(0) : option;
      rest = (*name)[0].second;
    }
    translated.append(rest, message.cend());
    throw UsageError(translated);
  }
}

}  // namespace tetrec
