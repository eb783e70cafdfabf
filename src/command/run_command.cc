// Errors to lines and exit codes.
#include "command/run_command.h"

#include "command/option_values.h"
#include "core/error.h"
#include "core/log.h"
#include "core/process_memory.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <new>
#include <regex>

namespace tetrec {

int RunCommand(CLI::App& app, int argc, char** argv, const std::function<void()>& body) {
  const auto fail = [&](const std::string& message, int code) {
    SetStatusLine("");
    fmt::print(stderr, "{}: {}\n", app.get_name(), OneLine(message));
    return code;
  };
  ReturnLargeBlocksWhenFreed();
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
  } catch (const CLI::ParseError& error) {
    return fail(std::string(error.what()) + " (see --help)", 2);
  } catch (const Error& error) {
    return fail(error.what(), error.exit_code());
  } catch (const std::bad_alloc&) {
    return fail("out of memory; use smaller pictures or a smaller mesh", 4);
  } catch (const std::filesystem::filesystem_error& error) {
    return fail(error.what(), 4);
  } catch (const std::exception& error) {
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
