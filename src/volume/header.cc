// Headers of volume files: lines, fields and values.
#include "volume/header.h"

#include "core/checked_json.h"
#include "core/error.h"
#include "core/lower_case.h"
#include "core/progress.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tetrec::internal {

std::string_view Trimmed(std::string_view text) {
  const char* blank = " \t\r\f\v";
  const size_t first = text.find_first_not_of(blank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blank) - first + 1);
}

std::vector<std::string_view> Words(std::string_view text) {
  std::vector<std::string_view> words;
  while (!(text = Trimmed(text)).empty()) {
    const size_t end = std::min(text.find_first_of(" \t\r\f\v"), text.size());
    words.push_back(text.substr(0, end));
    text.remove_prefix(end);
  }
  return words;
}

void HeaderField::Fail(const std::string& expected) const {
  std::string excerpt;
  for (const char c : text.substr(0, 60)) excerpt += c >= ' ' && c != 127 ? c : '?';
  throw DataError(
      fmt::format("{}, line {}: {} is \"{}\"; expected {}", file, line, name, excerpt, expected));
}

double HeaderField::FiniteFrom(std::string_view word, const char* expected) const {
  const double value = NumberFrom<double>(word, expected);
  if (!std::isfinite(value)) Fail(expected);
  return value;
}

glm::dvec3 HeaderField::Vector3(const char* expected) const {
  const std::vector<std::string_view> words = Words(text);
  if (words.size() != 3) Fail(expected);
  return {FiniteFrom(words[0], expected), FiniteFrom(words[1], expected),
          FiniteFrom(words[2], expected)};
}

glm::ivec3 HeaderField::Size() const {
  constexpr const char* kExpected = "three sample counts";
  const std::vector<std::string_view> words = Words(text);
  if (words.size() != 3) Fail(kExpected);
  return {NumberFrom<int>(words[0], kExpected), NumberFrom<int>(words[1], kExpected),
          NumberFrom<int>(words[2], kExpected)};
}

int64_t HeaderField::Integer(const char* expected) const {
  return NumberFrom<int64_t>(Trimmed(text), expected);
}

bool HeaderField::Flag() const {
  const std::string word = Lower(text);
  if (word == "true" || word == "1") return true;
  if (word == "false" || word == "0") return false;
  Fail("True or False");
}

std::filesystem::path HeaderField::FileInside() const {
  const std::filesystem::path path = std::filesystem::path(text).lexically_normal();
  if (!StaysInside(path)) Fail("a file inside the header's folder");
  return path;
}

void VolumeHeader::Add(std::string name, std::string_view text, int line) {
  if (fields_.contains(name)) {
    throw DataError(fmt::format("{}, line {}: {} is given twice", file_, line, name));
  }
  HeaderField field{name, std::string(text), file_, line};
  fields_.emplace(std::move(name), std::move(field));
}

const HeaderField* VolumeHeader::Find(const std::string& name) {
  used_.insert(name);
  const auto found = fields_.find(name);
  return found == fields_.end() ? nullptr : &found->second;
}

const HeaderField* VolumeHeader::FindAny(std::initializer_list<const char*> names) {
  const HeaderField* first = nullptr;
  for (const char* name : names) {
    const HeaderField* field = Find(name);
    if (first == nullptr) first = field;
  }
  return first;
}

const HeaderField& VolumeHeader::Get(const std::string& name) {
  const HeaderField* field = Find(name);
  if (field == nullptr) throw DataError(fmt::format("{}: {} is missing", file_, name));
  return *field;
}

std::vector<std::string> VolumeHeader::Unused() const {
  std::vector<std::string> names;
  for (const auto& [name, field] : fields_) {
    if (!used_.contains(name)) names.push_back(name);
  }
  return names;
}

std::optional<std::string_view> HeaderLines::Next() {
  if (position_ >= text_.size()) return std::nullopt;
  ++number_;
  const size_t end = std::min(text_.find('\n', position_), text_.size());
  if (end > kMaxVolumeHeaderBytes) {
    throw DataError(fmt::format("{}: the header does not end within {} bytes", file_,
                                WithThousands(kMaxVolumeHeaderBytes)));
  }
  const std::string_view line = text_.substr(position_, end - position_);
  position_ = std::min(end + 1, text_.size());
  return Trimmed(line);
}

}  // namespace tetrec::internal
