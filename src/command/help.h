// The page that --help shows, and hints for options that are nearly right.
#pragma once

#include <CLI/CLI.hpp>

#include <initializer_list>
#include <string>

namespace tetrec {

// Wide enough for most terminals [columns].
inline constexpr size_t kHelpWidth = 100;

// Wraps everything to kHelpWidth: names, kind and default of an option at the left, the description
// beside or below them.
class HelpFormatter : public CLI::Formatter {
 public:
  std::string make_description(const CLI::App* app) const override;
  std::string make_option(const CLI::Option* option, bool is_positional) const override;
};

// Lists these options under a heading of their own.
void GroupOptions(CLI::App& app, const std::string& heading,
                  std::initializer_list<const char*> names);

// The program's long option that is most like `word`; empty if none is at most two letters away and
// none continues it.
std::string NearestOption(const CLI::App& app, const std::string& word);

}  // namespace tetrec
