// The command line of a program that is no stage.
#include "core/plain_command.h"

#include "core/error.h"

#include <fmt/format.h>

namespace tetrec {

int RunPlainCommand(CLI::App& app, int argc, char** argv, const std::function<void()>& body) {
  const std::string name = app.get_name();
  try {
    app.parse(argc, argv);
    body();
    return 0;
  } catch (const CLI::CallForHelp&) {
    fmt::print("{}", app.help());
    return 0;
  } catch (const CLI::ParseError& error) {
    fmt::print(stderr, "{}: {} (see --help)\n", name, error.what());
    return 2;
  } catch (const Error& error) {
    fmt::print(stderr, "{}: {}\n", name, error.what());
    return error.exit_code();
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}: bug: {}\n", name, error.what());
    return 1;
  }
}

}  // namespace tetrec
