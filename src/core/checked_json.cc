// Checked access to JSON values.
#include "core/checked_json.h"

#include "core/error.h"
#include "core/printable.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <system_error>

namespace tetrec {
namespace {

template <class Number>
std::string Range(Number min, Number max) {
  return min == max ? fmt::format("{}", min) : fmt::format("{} to {}", min, max);
}

}  // namespace

CheckedJson::CheckedJson(const nlohmann::json& value, const std::filesystem::path& file)
    : value_(value), file_(file.string()) {}

CheckedJson::CheckedJson(const nlohmann::json& value, std::string file, std::string field)
    : value_(value), file_(std::move(file)), field_(std::move(field)) {}

void CheckedJson::Fail(const std::string& what) const {
  throw DataError(
      fmt::format("{}: {} {}", file_, field_.empty() ? "the whole file" : field_, what));
}

std::string CheckedJson::Excerpt() const {
  if (value_.is_object()) return "an object";
  if (value_.is_array()) return fmt::format("an array of {}", value_.size());
  const std::string text = value_.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  return text.size() > 60 ? text.substr(0, 60) + "..." : text;
}

bool CheckedJson::Has(const std::string& name) const {
  if (!value_.is_object()) Fail(fmt::format("is {}; expected an object", Excerpt()));
  return value_.contains(name);
}

CheckedJson CheckedJson::Field(const std::string& name) const {
  const CheckedJson field(value_, file_, field_.empty() ? name : field_ + "." + name);
  if (!Has(name)) field.Fail("is missing");
  return {value_.at(name), field.file_, field.field_};
}

std::vector<std::string> CheckedJson::Names() const {
  if (!value_.is_object()) Fail(fmt::format("is {}; expected an object", Excerpt()));
  std::vector<std::string> names;
  for (const auto& field : value_.items()) names.push_back(field.key());
  return names;
}

bool CheckedJson::IsArray() const { return value_.is_array(); }

size_t CheckedJson::Size() const {
  if (!value_.is_array()) Fail(fmt::format("is {}; expected an array", Excerpt()));
  return value_.size();
}

CheckedJson CheckedJson::Item(size_t index) const {
  if (index >= Size()) Fail(fmt::format("has {} items; expected more than {}", Size(), index));
  return {value_[index], file_, fmt::format("{}[{}]", field_, index)};
}

double CheckedJson::Number() const {
  if (!value_.is_number()) Fail(fmt::format("is {}; expected a number", Excerpt()));
  const double number = value_.get<double>();
  if (!std::isfinite(number)) Fail(fmt::format("is {}; expected a finite number", Excerpt()));
  return number;
}

double CheckedJson::NumberIn(double min, double max) const {
  const double number = Number();
  if (number < min || number > max) {
    Fail(fmt::format("is {}; expected {}", Excerpt(), Range(min, max)));
  }
  return number;
}

double CheckedJson::NumberOrTextIn(double min, double max) const {
  if (!value_.is_string()) return NumberIn(min, max);
  const std::string& text = value_.get_ref<const std::string&>();
  const char* end = text.data() + text.size();
  double number = 0;
  const std::from_chars_result parsed = std::from_chars(text.data(), end, number);
  const bool is_number = parsed.ec == std::errc() && parsed.ptr == end && std::isfinite(number);
  if (!is_number) Fail(fmt::format("is {}; expected a number", Excerpt()));
  if (number < min || number > max) {
    Fail(fmt::format("is {}; expected {}", Excerpt(), Range(min, max)));
  }
  return number;
}

int64_t CheckedJson::IntegerIn(int64_t min, int64_t max) const {
  if (!value_.is_number_integer()) Fail(fmt::format("is {}; expected a whole number", Excerpt()));
  const bool too_big = value_.is_number_unsigned() && value_.get<uint64_t>() > uint64_t(INT64_MAX);
  const int64_t number = too_big ? INT64_MAX : value_.get<int64_t>();
  if (too_big || number < min || number > max) {
    Fail(fmt::format("is {}; expected {}", Excerpt(), Range(min, max)));
  }
  return number;
}

bool CheckedJson::Flag() const {
  if (!value_.is_boolean()) Fail(fmt::format("is {}; expected true or false", Excerpt()));
  return value_.get<bool>();
}

bool CheckedJson::IsNull() const { return value_.is_null(); }

bool CheckedJson::IsOff() const {
  return value_.is_null() || (value_.is_boolean() && !value_.get<bool>()) ||
         (value_.is_number() && value_.get<double>() == 0);
}

std::string CheckedJson::Text() const {
  if (!value_.is_string()) Fail(fmt::format("is {}; expected text", Excerpt()));
  return value_.get<std::string>();
}

glm::dvec3 CheckedJson::Vector3() const {
  if (Size() != 3) Fail(fmt::format("has {} items; expected 3 numbers", Size()));
  return {Item(0).Number(), Item(1).Number(), Item(2).Number()};
}

glm::dmat3 CheckedJson::Matrix3() const {
  if (Size() != 3) Fail(fmt::format("has {} items; expected 3 rows", Size()));
  return glm::transpose(glm::dmat3(Item(0).Vector3(), Item(1).Vector3(), Item(2).Vector3()));
}

nlohmann::json ToJson(const glm::dvec3& vector) { return {vector.x, vector.y, vector.z}; }

nlohmann::json ToJson(const glm::dmat3& matrix) {
  const glm::dmat3 rows = glm::transpose(matrix);
  return nlohmann::json::array({ToJson(rows[0]), ToJson(rows[1]), ToJson(rows[2])});
}

bool StaysInside(const std::filesystem::path& path) {
  if (path.empty() || path.has_root_path()) return false;
  for (const std::filesystem::path& part : path) {
    if (part == "..") return false;
  }
  return path.string() == Printable(path.string());
}

}  // namespace tetrec
