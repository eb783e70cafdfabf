// Options of the command line that choose one of an enumeration's values by its word.
#pragma once

#include "core/words.h"

#include <CLI/CLI.hpp>

#include <optional>
#include <string>
#include <vector>

namespace tetrec {

template <class E>
std::vector<std::string> NamesOf() {
  std::vector<std::string> names;
  for (const Word<E>& entry : kWords<E>) names.emplace_back(entry.word);
  return names;
}

// `value` holds the default.
template <class E>
CLI::Option* AddWordOption(CLI::App& app, const std::string& option, E& value,
                           const std::string& help) {
  return app
      .add_option_function<std::string>(
          option, [&value](const std::string& word) { value = *FromName<E>(word); }, help)
      ->check(CLI::IsMember(NamesOf<E>()))
      ->default_str(Name(value));
}

// `none`, the default, is the word for no value.
template <class E>
CLI::Option* AddWordOption(CLI::App& app, const std::string& option, std::optional<E>& value,
                           const std::string& none, const std::string& help) {
  std::vector<std::string> names = NamesOf<E>();
  names.insert(names.begin(), none);
  return app
      .add_option_function<std::string>(
          option, [&value](const std::string& word) { value = FromName<E>(word); }, help)
      ->check(CLI::IsMember(names))
      ->default_str(none);
}

}  // namespace tetrec
