// Enumerations and the words for their values, in files and on the command line.
#pragma once

#include "core/error.h"

#include <fmt/format.h>

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

namespace tetrec {

template <class E>
struct Word {
  E value;
  const char* word;
};

// An enumeration specialises this beside its definition, with one entry per value:
//   template <>
//   inline constexpr auto kWords<Split> = std::to_array<Word<Split>>({{Split::kTrain, "train"}});
template <class E>
inline constexpr std::array<Word<E>, 0> kWords{};

template <class E>
requires std::is_enum_v<E>
const char* Name(E value) {
  static_assert(!kWords<E>.empty(), "this enumeration has no words");
  for (const Word<E>& entry : kWords<E>) {
    if (entry.value == value) return entry.word;
  }
  throw BugError(fmt::format("no word for the value {}", int(value)));
}

// None if no value has the name.
template <class E>
std::optional<E> FromName(std::string_view name) {
  static_assert(!kWords<E>.empty(), "this enumeration has no words");
  for (const Word<E>& entry : kWords<E>) {
    if (name == entry.word) return entry.value;
  }
  return std::nullopt;
}

// "train, validation or test"
template <class E>
std::string AllNames() {
  std::string names;
  for (const Word<E>& entry : kWords<E>) {
    const bool is_last = &entry == &kWords<E>.back();
    names += fmt::format("{}{}", names.empty() ? "" : is_last ? " or " : ", ", entry.word);
  }
  return names;
}

}  // namespace tetrec
