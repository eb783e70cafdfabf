// Options whose text stands for a value: a word of an enumeration, or anything that a function
// parses.
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

// `value` contains the default.
template <class E>
CLI::Option* AddWordOption(CLI::App& app, const std::string& option, E& value,
                           const std::string& help) {
  return app
      .add_option_function<std::string>(
          option, [&value](const std::string& word) { value = *FromName<E>(word); }, help)
      ->check(CLI::IsMember(NamesOf<E>()))
      ->default_str(Name(value));
}

// A list of words with commas between them; `values` contains the default.
template <class E>
CLI::Option* AddWordsOption(CLI::App& app, const std::string& option, std::vector<E>& values,
                            const std::string& help) {
  std::string default_text;
  for (const E value : values)
    default_text += (default_text.empty() ? "" : ",") + std::string(Name(value));
  return app
      .add_option_function<std::vector<std::string>>(
          option,
          [&values](const std::vector<std::string>& words) {
            values.clear();
            for (const std::string& word : words) values.push_back(*FromName<E>(word));
          },
          help)
      ->delimiter(',')
      ->check(CLI::IsMember(NamesOf<E>()))
      ->default_str(default_text);
}

// Without a default, and without a word for no value.
template <class E>
CLI::Option* AddWordOption(CLI::App& app, const std::string& option, std::optional<E>& value,
                           const std::string& help) {
  return app
      .add_option_function<std::string>(
          option, [&value](const std::string& word) { value = FromName<E>(word); }, help)
      ->check(CLI::IsMember(NamesOf<E>()))
      ->default_str("");
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

// `parse` makes the value from the option's text and throws UsageError if it cannot.
// `default_text` is the text for the default.
template <class T>
CLI::Option* AddParsedOption(CLI::App& app, const std::string& option, T& value,
                             T (*parse)(const std::string&), const std::string& default_text,
                             const std::string& help) {
  return app
      .add_option_function<std::string>(
          option,
          [&value, option, parse](const std::string& text) {
            try {
              value = parse(text);
            } catch (const UsageError& error) {
              throw CLI::ValidationError(option, error.what());
            }
          },
          help)
      ->default_str(default_text);
}

}  // namespace tetrec
