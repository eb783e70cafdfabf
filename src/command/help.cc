// The page that --help shows, and hints for options that are nearly right.
#include "command/help.h"

#include <algorithm>
#include <numeric>
#include <sstream>
#include <utility>
#include <vector>

namespace tetrec {
namespace {

constexpr size_t kIndent = 2, kDescriptionAt = 30;

// The words of `text` in lines of at most kHelpWidth columns, the first of which starts behind
// `first` columns, the others behind `rest`.
std::string Wrapped(const std::string& text, size_t first, size_t rest) {
  std::istringstream words(text);
  std::string wrapped;
  size_t column = first;
  bool at_start = true;
  for (std::string word; words >> word;) {
    if (!at_start && column + 1 + word.size() > kHelpWidth) {
      wrapped += "\n" + std::string(rest, ' ');
      column = rest;
      at_start = true;
    }
    wrapped += (at_start ? "" : " ") + word;
    column += word.size() + (at_start ? 0 : 1);
    at_start = false;
  }
  return wrapped;
}

// A list of words is one word to Wrapped, and may be long.
std::string WithBreaks(std::string text) {
  for (size_t at = 0; (at = text.find(',', at)) != std::string::npos; ++at) {
    if (at + 1 < text.size() && text[at + 1] != ' ') text.insert(at + 1, " ");
  }
  return text;
}

// The number of letters to add, remove or change (Levenshtein 1966).
size_t EditDistance(const std::string& a, const std::string& b) {
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (size_t i = 1; i <= a.size(); ++i) {
    size_t diagonal = std::exchange(row[0], i);
    for (size_t j = 1; j <= b.size(); ++j) {
      const size_t changed = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({changed, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

}  // namespace

std::string HelpFormatter::make_description(const CLI::App* app) const {
  std::istringstream lines(Formatter::make_description(app));
  std::string wrapped;
  for (std::string line; std::getline(lines, line);) {
    const size_t indent = std::min(line.find_first_not_of(' '), line.size());
    wrapped += line.substr(0, indent) + Wrapped(line, indent, indent) + "\n";
  }
  return wrapped;
}

std::string HelpFormatter::make_option(const CLI::Option* option, bool is_positional) const {
  const std::string left = make_option_name(option, is_positional) + make_option_opts(option);
  std::string text = std::string(kIndent, ' ');
  if (kIndent + left.size() + 2 <= kDescriptionAt) {
    text += left + std::string(kDescriptionAt - kIndent - left.size(), ' ');
  } else {
    text +=
        Wrapped(WithBreaks(left), kIndent, 3 * kIndent) + "\n" + std::string(kDescriptionAt, ' ');
  }
  return text + Wrapped(make_option_desc(option), kDescriptionAt, kDescriptionAt) + "\n";
}

void GroupOptions(CLI::App& app, const std::string& heading,
                  std::initializer_list<const char*> names) {
  for (const char* name : names) app.get_option(name)->group(heading);
}

std::string NearestOption(const CLI::App& app, const std::string& word) {
  constexpr size_t kLargestDistance = 2;
  const std::string typed = word.substr(0, word.find('='));
  std::string nearest;
  size_t least = kLargestDistance + 1;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) {
      const std::string full = "--" + name;
      const bool continues = typed.size() > 3 && full.starts_with(typed);
      const size_t distance = continues ? 0 : EditDistance(typed, full);
      if (distance >= least) continue;
      least = distance;
      nearest = full;
    }
  }
  return nearest;
}

}  // namespace tetrec
