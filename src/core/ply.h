// PLY files, any elements and scalar or list properties; ASCII and binary little and big endian in,
// binary little endian out. Counts are checked against the file's size before memory is allocated.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace tetrec {

enum class PlyType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kFloat;
  bool is_list = false;
  PlyType count_type = PlyType::kUint8;  // lists only
  std::vector<double> values;  // scalars: one per item; lists: the values of all items in order
  std::vector<uint32_t> list_sizes;  // lists only, one per item
};

struct PlyElement {
  std::string name;
  uint64_t count = 0;
  std::vector<PlyProperty> properties;
  // nullptr if none has this name.
  const PlyProperty* Find(const std::string& property) const;
};

struct PlyFile {
  std::vector<std::string> comments;
  std::vector<PlyElement> elements;
  const PlyElement* Find(const std::string& element) const;
};

// Throws DataError naming path and line or byte.
PlyFile ParsePly(std::span<const uint8_t> bytes, const std::string& name);
PlyFile ReadPly(const std::filesystem::path& path);
void WritePly(const std::filesystem::path& path, const PlyFile& file);

}  // namespace tetrec
