// JSON from outside, read field by field: every access is checked, and a failure names the file and
// the field, e.g. "scene.json: views[3].camera is 7; expected 0 to 1".
#pragma once

#include <glm/glm.hpp>
#include <nlohmann/json.hpp>

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace tetrec {

// A value and its place in a file. Every function throws DataError if the value is not of the kind
// that the function names.
class CheckedJson {
 public:
  // Keeps a reference to `file`.
  CheckedJson(const nlohmann::json& value, const std::filesystem::path& file);

  bool Has(const std::string& name) const;  // of an object
  CheckedJson Field(const std::string& name) const;
  std::vector<std::string> Names() const;  // of an object's fields, sorted
  bool IsArray() const;
  size_t Size() const;  // of an array
  CheckedJson Item(size_t index) const;

  double Number() const;  // finite
  double NumberIn(double min, double max) const;
  // The same, where a text that is nothing but a number, such as "0.01", counts as that number.
  double NumberOrTextIn(double min, double max) const;
  int64_t IntegerIn(int64_t min, int64_t max) const;
  bool Flag() const;
  bool IsNull() const;
  bool IsOff() const;  // false, null or 0
  std::string Text() const;
  glm::dvec3 Vector3() const;  // [x, y, z]
  glm::dmat3 Matrix3() const;  // rows

  // "<file>: <field> <what>"
  [[noreturn]] void Fail(const std::string& what) const;

 private:
  CheckedJson(const nlohmann::json& value, std::string file, std::string field);
  std::string Excerpt() const;

  const nlohmann::json& value_;
  std::string file_, field_;
};

nlohmann::json ToJson(const glm::dvec3& vector);
nlohmann::json ToJson(const glm::dmat3& matrix);  // rows

// True for a relative path of plain components: no "..", no root, no control characters, UTF-8.
// Other names could be neither printed nor stored.
bool StaysInside(const std::filesystem::path& path);

}  // namespace tetrec
