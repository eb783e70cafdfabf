// Values of options as JSON, and a check of numbers.
#include "command/option_values.h"

#include "core/error.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

namespace tetrec {
using nlohmann::json;
namespace {

// A number if the text is one, so that "1e-3" and "0.001" are the same value.
json ParsedValue(const std::string& text) {
  const char* end = text.data() + text.size();
  int64_t whole = 0;
  if (const auto r = std::from_chars(text.data(), end, whole); r.ec == std::errc() && r.ptr == end)
    return whole;
  double real = 0;
  if (const auto r = std::from_chars(text.data(), end, real);
      r.ec == std::errc() && r.ptr == end && std::isfinite(real)) {
    if (real == std::floor(real) && std::abs(real) < 9e15) return int64_t(real);
    return real;
  }
  if (text == "true") return true;
  if (text == "false") return false;
  return text;
}

bool IsTooLarge(const std::string& text) {
  uint64_t whole = 0;
  return std::from_chars(text.data(), text.data() + text.size(), whole).ec ==
         std::errc::result_out_of_range;
}

}  // namespace

json OptionValue(const CLI::Option& option) {
  if (option.count() > 0) {
    const std::vector<std::string> results = option.reduced_results();
    if (results.size() == 1) return ParsedValue(results[0]);
    json values = json::array();
    for (const std::string& text : results) values.push_back(ParsedValue(text));
    return values;
  }
  if (option.get_items_expected_max() == 0) {
    TETREC_CHECK(
        option.get_fnames().empty(),
        "a flag that can be negated does not reveal its default: use an option with words");
    return false;
  }
  return ParsedValue(option.get_default_str());
}

void CheckNumbers(const CLI::App& app) {
  for (const CLI::Option* option : app.get_options()) {
    const std::string type = option->get_type_name();
    for (const std::string& text : option->results()) {
      const char* want = nullptr;
      if (type.starts_with("UINT") && text.starts_with("-")) want = "a whole number of 0 or more";
      if (type.starts_with("FLOAT") && !std::isfinite(std::strtod(text.c_str(), nullptr)))
        want = "a finite number";
      if (type.find("INT") < 2 && IsTooLarge(text)) want = "a smaller number";
      if (text.empty()) throw UsageError(fmt::format("{} is empty", option->get_name()));
      if (want != nullptr)
        throw UsageError(fmt::format("{} is {}; expected {}", option->get_name(), text, want));
    }
  }
}

}  // namespace tetrec
