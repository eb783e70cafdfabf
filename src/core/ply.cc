// Reading and writing of PLY headers and values.
#include "core/ply.h"

#include "core/error.h"
#include "core/file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <limits>
#include <string_view>
#include <type_traits>

namespace tetrec {
namespace {

enum class Format { kAscii, kLittleEndian, kBigEndian };

struct TypeInfo {
  PlyType type;
  const char* name;
  const char* alias;
  size_t bytes;
  double min, max;  // integers only
};

constexpr double kNoLimit = 0;
constexpr TypeInfo kTypes[] = {
    {PlyType::kInt8, "char", "int8", 1, -128.0, 127.0},
    {PlyType::kUint8, "uchar", "uint8", 1, 0.0, 255.0},
    {PlyType::kInt16, "short", "int16", 2, -32768.0, 32767.0},
    {PlyType::kUint16, "ushort", "uint16", 2, 0.0, 65535.0},
    {PlyType::kInt32, "int", "int32", 4, -2147483648.0, 2147483647.0},
    {PlyType::kUint32, "uint", "uint32", 4, 0.0, 4294967295.0},
    {PlyType::kFloat, "float", "float32", 4, kNoLimit, kNoLimit},
    {PlyType::kDouble, "double", "float64", 8, kNoLimit, kNoLimit},
};

const TypeInfo& Info(PlyType type) { return kTypes[size_t(type)]; }
bool IsInteger(PlyType type) { return type != PlyType::kFloat && type != PlyType::kDouble; }

// Calls visit(T{}) with the C++ type.
template <class Visit>
auto WithType(PlyType type, Visit&& visit) {
  switch (type) {
    case PlyType::kInt8:
      return visit(int8_t{});
    case PlyType::kUint8:
      return visit(uint8_t{});
    case PlyType::kInt16:
      return visit(int16_t{});
    case PlyType::kUint16:
      return visit(uint16_t{});
    case PlyType::kInt32:
      return visit(int32_t{});
    case PlyType::kUint32:
      return visit(uint32_t{});
    case PlyType::kFloat:
      return visit(float{});
    case PlyType::kDouble:
      break;
  }
  return visit(double{});
}

std::vector<std::string> SplitWords(std::string_view line) {
  std::vector<std::string> words;
  size_t at = 0;
  while ((at = line.find_first_not_of(" \t", at)) != std::string_view::npos) {
    const size_t end = std::min(line.find_first_of(" \t", at), line.size());
    words.emplace_back(line.substr(at, end - at));
    at = end;
  }
  return words;
}

// The header's lines, with their numbers for messages.
class HeaderReader {
 public:
  HeaderReader(std::string_view text, const std::string& name) : text_(text), name_(name) {}

  std::string_view NextLine() {
    ++line_;
    const size_t end = text_.find('\n', at_);
    if (end == std::string_view::npos)
      throw DataError(name_ + ": the PLY header does not end (no end_header line)");
    std::string_view line = text_.substr(at_, end - at_);
    at_ = end + 1;
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    return line;
  }
  [[noreturn]] void Fail(const std::string& what) const {
    throw DataError(fmt::format("{}: line {}: {}", name_, line_, what));
  }
  PlyType Type(const std::string& word) const {
    for (const TypeInfo& info : kTypes) {
      if (word == info.name || word == info.alias) return info.type;
    }
    Fail(fmt::format("\"{}\" is not a PLY type", word));
  }
  size_t position() const { return at_; }

 private:
  std::string_view text_;
  const std::string& name_;
  size_t at_ = 0, line_ = 0;
};

PlyProperty ParseProperty(const std::vector<std::string>& words, const HeaderReader& header) {
  PlyProperty property;
  if (words.size() == 3) {
    property.type = header.Type(words[1]);
    property.name = words[2];
  } else if (words.size() == 5 && words[1] == "list") {
    property.is_list = true;
    property.count_type = header.Type(words[2]);
    property.type = header.Type(words[3]);
    property.name = words[4];
    if (!IsInteger(property.count_type))
      header.Fail("the length of a list must have an integer type");
  } else {
    header.Fail("expected \"property TYPE NAME\" or \"property list TYPE TYPE NAME\"");
  }
  return property;
}

PlyElement ParseElement(const std::vector<std::string>& words, const HeaderReader& header) {
  PlyElement element;
  if (words.size() != 3) header.Fail("expected \"element NAME COUNT\"");
  element.name = words[1];
  const std::string& count = words[2];
  const auto [end, error] =
      std::from_chars(count.data(), count.data() + count.size(), element.count);
  if (error != std::errc() || end != count.data() + count.size()) {
    header.Fail(fmt::format("\"{}\" is not a count", count));
  }
  return element;
}

Format ParseFormat(const std::vector<std::string>& words, const HeaderReader& header) {
  if (words.size() == 3 && words[2] == "1.0") {
    if (words[1] == "ascii") return Format::kAscii;
    if (words[1] == "binary_little_endian") return Format::kLittleEndian;
    if (words[1] == "binary_big_endian") return Format::kBigEndian;
  }
  header.Fail("expected \"format ascii|binary_little_endian|binary_big_endian 1.0\"");
}

// Fills comments and elements without their values; returns the format and moves the reader to the
// data.
Format ParseHeader(HeaderReader& header, PlyFile& file) {
  if (header.NextLine() != "ply") header.Fail("is not a PLY file (does not start with \"ply\")");
  const Format format = ParseFormat(SplitWords(header.NextLine()), header);
  while (true) {
    const std::string_view line = header.NextLine();
    const std::vector<std::string> words = SplitWords(line);
    const std::string keyword = words.empty() ? "" : words[0];
    if (keyword == "end_header") return format;
    if (keyword == "comment") {
      file.comments.emplace_back(line.substr(std::min(line.size(), line.find("comment") + 8)));
    } else if (keyword == "element") {
      file.elements.push_back(ParseElement(words, header));
    } else if (keyword == "property") {
      if (file.elements.empty()) header.Fail("a property before any element");
      file.elements.back().properties.push_back(ParseProperty(words, header));
    } else if (keyword != "obj_info") {
      header.Fail(fmt::format("unknown keyword \"{}\"", keyword));
    }
  }
}

class BinarySource {
 public:
  BinarySource(std::span<const uint8_t> bytes, const std::string& name, bool big_endian)
      : reader_(bytes, name), swap_(big_endian != (std::endian::native == std::endian::big)) {}

  double Value(PlyType type, const char* what) {
    return WithType(type, [&]<class T>(T) {
      std::array<uint8_t, sizeof(T)> bytes = reader_.Read<std::array<uint8_t, sizeof(T)>>(what);
      if (swap_) std::reverse(bytes.begin(), bytes.end());
      return double(std::bit_cast<T>(bytes));
    });
  }
  void CheckCount(uint64_t count, uint64_t min_bytes, const char* what) const {
    reader_.CheckCount(count, min_bytes, what);
  }
  static uint64_t MinBytes(PlyType type) { return Info(type).bytes; }
  void ExpectEnd() const { reader_.ExpectEnd(); }
  const std::string& name() const { return reader_.name(); }

 private:
  ByteReader reader_;
  bool swap_;
};

class AsciiSource {
 public:
  AsciiSource(std::string_view text, const std::string& name) : text_(text), name_(name) {}

  double Value(PlyType type, const char* what) {
    SkipSpace();
    if (at_ == text_.size()) {
      throw DataError(
          fmt::format("{}: ends at byte {} of its data where {} was expected", name_, at_, what));
    }
    const size_t end = std::min(text_.find_first_of(kSpace, at_), text_.size());
    const std::string_view word = text_.substr(at_, end - at_);
    double value = 0;
    const auto [rest, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    const bool number = error == std::errc() && rest == word.data() + word.size();
    const bool fits = !IsInteger(type) || (std::floor(value) == value && value >= Info(type).min &&
                                           value <= Info(type).max);
    if (!number || !fits) {
      throw DataError(fmt::format("{}: byte {} of its data: \"{}\" is not a valid {} for {}", name_,
                                  at_, word.substr(0, 40), Info(type).name, what));
    }
    at_ = end;
    return value;
  }
  void CheckCount(uint64_t count, uint64_t min_bytes, const char* what) const {
    // The last value needs no space after it.
    if (min_bytes > 0 && count > (text_.size() - at_ + 1) / min_bytes) {
      throw DataError(fmt::format("{}: {} {} do not fit in the remaining {} bytes", name_, count,
                                  what, text_.size() - at_));
    }
  }
  static uint64_t MinBytes(PlyType) { return 2; }  // a digit and a space
  void ExpectEnd() {
    SkipSpace();
    if (at_ < text_.size()) {
      throw DataError(fmt::format("{}: byte {} of its data: {} bytes are left over", name_, at_,
                                  text_.size() - at_));
    }
  }
  const std::string& name() const { return name_; }

 private:
  static constexpr std::string_view kSpace = " \t\r\n";
  void SkipSpace() { at_ = std::min(text_.find_first_not_of(kSpace, at_), text_.size()); }

  std::string_view text_;
  const std::string& name_;
  size_t at_ = 0;
};

template <class Source>
void ReadList(Source& source, PlyProperty& property) {
  const double length = source.Value(property.count_type, property.name.c_str());
  if (length < 0) {
    throw DataError(
        fmt::format("{}: a list of {} has the length {}", source.name(), property.name, length));
  }
  source.CheckCount(uint64_t(length), Source::MinBytes(property.type), property.name.c_str());
  property.list_sizes.push_back(uint32_t(length));
  for (uint32_t i = 0; i < uint32_t(length); ++i) {
    property.values.push_back(source.Value(property.type, property.name.c_str()));
  }
}

template <class Source>
void ReadElements(Source&& source, PlyFile& file) {
  for (PlyElement& element : file.elements) {
    if (element.count == 0) continue;
    uint64_t min_bytes = 0;
    for (const PlyProperty& p : element.properties)
      min_bytes += Source::MinBytes(p.is_list ? p.count_type : p.type);
    if (min_bytes == 0) {
      throw DataError(
          fmt::format("{}: the element {} has no properties", source.name(), element.name));
    }
    source.CheckCount(element.count, min_bytes, element.name.c_str());
    for (PlyProperty& p : element.properties)
      (p.is_list ? void(p.list_sizes.reserve(element.count)) : p.values.reserve(element.count));
    for (uint64_t i = 0; i < element.count; ++i) {
      for (PlyProperty& p : element.properties) {
        if (p.is_list) {
          ReadList(source, p);
        } else {
          p.values.push_back(source.Value(p.type, p.name.c_str()));
        }
      }
    }
  }
  source.ExpectEnd();
}

void WriteValue(ByteWriter& writer, PlyType type, double value, const std::string& name) {
  TETREC_CHECK(
      !IsInteger(type) ||
          (std::floor(value) == value && value >= Info(type).min && value <= Info(type).max),
      fmt::format("{} is not a valid {} for the PLY property {}", value, Info(type).name, name));
  WithType(type, [&]<class T>(T) { writer.Write(T(value)); });
}

std::string HeaderOf(const PlyFile& file) {
  std::string header = "ply\nformat binary_little_endian 1.0\n";
  for (const std::string& comment : file.comments) header += "comment " + comment + "\n";
  for (const PlyElement& element : file.elements) {
    header += fmt::format("element {} {}\n", element.name, element.count);
    for (const PlyProperty& p : element.properties) {
      const std::string list = p.is_list ? fmt::format("list {} ", Info(p.count_type).name) : "";
      header += fmt::format("property {}{} {}\n", list, Info(p.type).name, p.name);
    }
  }
  return header + "end_header\n";
}

void CheckSizes(const PlyElement& element) {
  for (const PlyProperty& p : element.properties) {
    uint64_t values = element.count;
    if (p.is_list) {
      values = 0;
      for (const uint32_t size : p.list_sizes) values += size;
    }
    TETREC_CHECK(p.values.size() == values && (!p.is_list || p.list_sizes.size() == element.count),
                 fmt::format("PLY {}.{} has {} values, not {}", element.name, p.name,
                             p.values.size(), values));
  }
}

}  // namespace

const PlyProperty* PlyElement::Find(const std::string& property) const {
  for (const PlyProperty& p : properties) {
    if (p.name == property) return &p;
  }
  return nullptr;
}

const PlyElement* PlyFile::Find(const std::string& element) const {
  for (const PlyElement& e : elements) {
    if (e.name == element) return &e;
  }
  return nullptr;
}

PlyFile ParsePly(std::span<const uint8_t> bytes, const std::string& name) {
  PlyFile file;
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  HeaderReader header(text, name);
  const Format format = ParseHeader(header, file);
  if (format == Format::kAscii) {
    ReadElements(AsciiSource(text.substr(header.position()), name), file);
  } else {
    ReadElements(BinarySource(bytes.subspan(header.position()), name, format == Format::kBigEndian),
                 file);
  }
  return file;
}

PlyFile ReadPly(const std::filesystem::path& path) {
  return ParsePly(ReadBytes(path), path.string());
}

void WritePly(const std::filesystem::path& path, const PlyFile& file) {
  static_assert(std::endian::native == std::endian::little);
  ByteWriter writer;
  const std::string header = HeaderOf(file);
  writer.WriteArray(std::span<const char>(header));
  for (const PlyElement& element : file.elements) {
    CheckSizes(element);
    std::vector<size_t> next(element.properties.size(), 0);
    for (uint64_t i = 0; i < element.count; ++i) {
      for (size_t k = 0; k < element.properties.size(); ++k) {
        const PlyProperty& p = element.properties[k];
        const uint32_t values = p.is_list ? p.list_sizes[i] : 1;
        if (p.is_list) WriteValue(writer, p.count_type, values, p.name);
        for (uint32_t v = 0; v < values; ++v)
          WriteValue(writer, p.type, p.values[next[k]++], p.name);
      }
    }
  }
  WriteBytes(path, writer.bytes());
}

}  // namespace tetrec
