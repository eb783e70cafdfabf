// Volume files.
#include "scene/volume_io.h"

#include "core/error.h"
#include "core/file.h"
#include "core/log.h"
#include "core/progress.h"
#include "scene/checked_json.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string_view>

namespace tetrec {
namespace {
namespace fs = std::filesystem;

// A header longer than this is none.
constexpr size_t kMaxHeaderBytes = size_t{1} << 20;
constexpr uint64_t kMaxFileBytes = uint64_t{1} << 34;

std::string_view Trimmed(std::string_view text) {
  const char* blank = " \t\r\f\v";
  const size_t first = text.find_first_not_of(blank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blank) - first + 1);
}

std::string Lower(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = char(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  return lower;
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

// One value of a header, and where it stands.
struct Field {
  std::string name, text;
  std::string file;
  int line = 0;

  [[noreturn]] void Fail(const std::string& expected) const {
    std::string excerpt;
    for (const char c : text.substr(0, 60)) excerpt += c >= ' ' && c != 127 ? c : '?';
    throw DataError(
        fmt::format("{}, line {}: {} is \"{}\"; expected {}", file, line, name, excerpt, expected));
  }
  template <class T>
  T NumberFrom(std::string_view word, const char* expected) const {
    T value{};
    if (!word.empty() && word[0] == '+') word.remove_prefix(1);
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size()) Fail(expected);
    return value;
  }
  double FiniteFrom(std::string_view word, const char* expected) const {
    const double value = NumberFrom<double>(word, expected);
    if (!std::isfinite(value)) Fail(expected);
    return value;
  }
  glm::dvec3 Vector3(const char* expected) const {
    const std::vector<std::string_view> words = Words(text);
    if (words.size() != 3) Fail(expected);
    return {FiniteFrom(words[0], expected), FiniteFrom(words[1], expected),
            FiniteFrom(words[2], expected)};
  }
  glm::ivec3 Size() const {
    constexpr const char* kExpected = "three numbers of samples";
    const std::vector<std::string_view> words = Words(text);
    if (words.size() != 3) Fail(kExpected);
    return {NumberFrom<int>(words[0], kExpected), NumberFrom<int>(words[1], kExpected),
            NumberFrom<int>(words[2], kExpected)};
  }
  int64_t Integer(const char* expected) const {
    return NumberFrom<int64_t>(Trimmed(text), expected);
  }
  bool Flag() const {
    const std::string word = Lower(text);
    if (word == "true" || word == "1") return true;
    if (word == "false" || word == "0") return false;
    Fail("True or False");
  }
};

// The fields of a header by name; counts which were asked for.
class Header {
 public:
  explicit Header(std::string file) : file_(std::move(file)) {}

  void Add(std::string name, std::string_view text, int line) {
    if (fields_.contains(name)) {
      throw DataError(fmt::format("{}, line {}: {} is there twice", file_, line, name));
    }
    Field field{name, std::string(text), file_, line};
    fields_.emplace(std::move(name), std::move(field));
  }
  const Field* Find(const std::string& name) {
    used_.insert(name);
    const auto found = fields_.find(name);
    return found == fields_.end() ? nullptr : &found->second;
  }
  // The first of several names for one thing.
  const Field* FindAny(std::initializer_list<const char*> names) {
    const Field* first = nullptr;
    for (const char* name : names) {
      const Field* field = Find(name);
      if (first == nullptr) first = field;
    }
    return first;
  }
  const Field& Get(const std::string& name) {
    const Field* field = Find(name);
    if (field == nullptr) throw DataError(fmt::format("{}: {} is missing", file_, name));
    return *field;
  }
  std::vector<std::string> Unused() const {
    std::vector<std::string> names;
    for (const auto& [name, field] : fields_) {
      if (!used_.contains(name)) names.push_back(name);
    }
    return names;
  }
  const std::string& file() const { return file_; }

 private:
  std::string file_;
  std::map<std::string, Field> fields_;
  std::set<std::string> used_;
};

// Lines of a header at the front of a file.
class Lines {
 public:
  Lines(std::span<const uint8_t> bytes, std::string file)
      : text_(reinterpret_cast<const char*>(bytes.data()), bytes.size()), file_(std::move(file)) {}

  // Nothing at the end of the file.
  std::optional<std::string_view> Next() {
    if (position_ >= text_.size()) return std::nullopt;
    ++number_;
    const size_t end = std::min(text_.find('\n', position_), text_.size());
    if (end > kMaxHeaderBytes) {
      throw DataError(fmt::format("{}: has no end of its header within {} bytes", file_,
                                  WithThousands(kMaxHeaderBytes)));
    }
    const std::string_view line = text_.substr(position_, end - position_);
    position_ = std::min(end + 1, text_.size());
    return Trimmed(line);
  }
  size_t position() const { return position_; }  // [bytes], behind the last line
  int number() const { return number_; }         // of the last line, from 1

 private:
  std::string_view text_;
  std::string file_;
  size_t position_ = 0;
  int number_ = 0;
};

// Where the samples are, as a header says.
struct Placement {
  fs::path data_file;            // empty: behind the header
  uint64_t skip = 0;             // [bytes] from there
  bool skip_to_samples = false;  // the samples are the last bytes of the file
  bool compressed = false;       // gzip or zlib
};

struct ParsedHeader {
  VolumeLayout layout;
  Placement placement;
  size_t header_bytes = 0;
  std::vector<std::string> unused_fields;
};

// --- NRRD

SampleType NrrdType(const Field& field) {
  static const std::map<std::string, SampleType> kTypes = {
      {"uchar", SampleType::kUint8},
      {"unsigned char", SampleType::kUint8},
      {"uint8", SampleType::kUint8},
      {"uint8_t", SampleType::kUint8},
      {"ushort", SampleType::kUint16},
      {"unsigned short", SampleType::kUint16},
      {"unsigned short int", SampleType::kUint16},
      {"uint16", SampleType::kUint16},
      {"uint16_t", SampleType::kUint16},
      {"float", SampleType::kFloat32}};
  std::string spelling;
  for (const std::string_view word : Words(field.text)) {
    if (!spelling.empty()) spelling += ' ';
    spelling += Lower(word);
  }
  const auto found = kTypes.find(spelling);
  if (found == kTypes.end()) field.Fail("uint8, uint16 or float");
  return found->second;
}

// "(a,b,c)"
glm::dvec3 NrrdVector(const Field& field, std::string_view& text) {
  constexpr const char* kExpected = "vectors like (1,0,0) (0,1,0) (0,0,1)";
  text = Trimmed(text);
  const size_t end = text.find(')');
  if (text.empty() || text[0] != '(' || end == std::string_view::npos) field.Fail(kExpected);
  std::string_view inside = text.substr(1, end - 1);
  glm::dvec3 vector(0.0);
  for (int axis = 0; axis < 3; ++axis) {
    const size_t comma = inside.find(',');
    if ((comma == std::string_view::npos) != (axis == 2)) field.Fail(kExpected);
    vector[axis] = field.FiniteFrom(Trimmed(inside.substr(0, comma)), kExpected);
    if (axis < 2) inside.remove_prefix(comma + 1);
  }
  text.remove_prefix(end + 1);
  return vector;
}

// Axes that are no places of one number's samples are refused.
void CheckNrrdKinds(Header& header) {
  const Field* kinds = header.Find("kinds");
  if (kinds == nullptr) return;
  const auto is_place = [](std::string_view word) {
    const std::string kind = Lower(word);
    return kind == "space" || kind == "domain" || kind == "none" || kind == "???";
  };
  const std::vector<std::string_view> words = Words(kinds->text);
  if (words.size() != 3 || !std::all_of(words.begin(), words.end(), is_place)) {
    kinds->Fail(
        "space, domain or none for each of the three axes; colours, vectors, times and other lists "
        "are not read");
  }
}

// Only the handedness matters: a left-handed space would come out mirrored. Names go with hyphens,
// with blanks, and without either.
void CheckNrrdSpace(Header& header) {
  static const std::set<std::string> kRightHanded = {
      "rightanteriorsuperior", "ras", "leftposteriorsuperior", "lps", "scannerxyz",
      "3drighthanded"};
  static const std::set<std::string> kLeftHanded = {"leftanteriorsuperior", "las", "3dlefthanded"};
  const Field* dimension = header.FindAny({"space dimension", "spacedimension"});
  if (dimension != nullptr && dimension->Integer("a number") != 3) dimension->Fail("3");
  const Field* space = header.Find("space");
  if (space == nullptr) return;
  std::string name = Lower(space->text);
  std::erase_if(name, [](char c) { return c == '-' || c == ' '; });
  if (kLeftHanded.contains(name)) {
    space->Fail(
        "a right-handed space: a left-handed one would be read as its mirror image; convert it to "
        "right-anterior-superior or left-posterior-superior");
  }
  if (!kRightHanded.contains(name)) {
    space->Fail("right-anterior-superior, left-posterior-superior, scanner-xyz or 3D-right-handed");
  }
}

// What an axis's ends are: the places of its outermost samples, or the far sides of their cells.
enum class NrrdCentering { kUnknown, kNode, kCell };

std::array<NrrdCentering, 3> NrrdCenterings(Header& header) {
  std::array<NrrdCentering, 3> centerings{};
  const Field* field = header.FindAny({"centerings", "centers"});
  if (field == nullptr) return centerings;
  constexpr const char* kExpected = "node, cell or none for each of the three axes";
  const std::vector<std::string_view> words = Words(field->text);
  if (words.size() != 3) field->Fail(kExpected);
  for (size_t axis = 0; axis < 3; ++axis) {
    const std::string word = Lower(words[axis]);
    if (word == "node") centerings[axis] = NrrdCentering::kNode;
    if (word == "cell") centerings[axis] = NrrdCentering::kCell;
    if (centerings[axis] == NrrdCentering::kUnknown && word != "none" && word != "???") {
      field->Fail(kExpected);
    }
  }
  return centerings;
}

// One axis from its ends; `told`: its spacing, where the header has spacings; `max`: where it has
// axis maxs.
struct NrrdAxis {
  const Field& mins;
  double min;
  std::optional<double> max, told;
  int samples;
  NrrdCentering centering;

  // Spacings from one end to the other.
  double Steps() const { return samples - (centering == NrrdCentering::kCell ? 0 : 1); }
  // Without word of it the definition leaves it open; teem takes cells, others nodes. Spacings
  // decide where both ends are told.
  void FindCentering() {
    if (centering != NrrdCentering::kUnknown) return;
    if (!max || !told) {
      mins.Fail("centerings beside it, node or cell for each axis, which say what its ends are");
    }
    centering = (*max - min) / *told > samples - 0.5 ? NrrdCentering::kCell : NrrdCentering::kNode;
  }
  double Spacing() const {
    if (!max) return *told;
    const double spacing = (*max - min) / Steps();
    if (!told) return spacing;
    // Far from node against cell, which is a whole step; spacings are often written rounded.
    constexpr double kMostSteps = 0.25;
    if (!(std::abs((*max - min) / *told - Steps()) <= kMostSteps)) {
      mins.Fail(fmt::format(
          "ends that agree with spacings: along an axis these are {}, axis mins and maxs make {}",
          *told, spacing));
    }
    return *told;
  }
};

// Spacing and origin from axis mins and maxs.
void ReadNrrdEnds(Header& header, VolumeLayout& layout) {
  const Field* mins = header.FindAny({"axis mins", "axismins"});
  const Field* maxs = header.FindAny({"axis maxs", "axismaxs"});
  if (mins == nullptr && maxs == nullptr) return;
  if (mins == nullptr) maxs->Fail("axis mins beside it");
  for (const char* name : {"space directions", "spacedirections", "space origin", "spaceorigin"}) {
    if (header.Find(name) != nullptr) mins->Fail(fmt::format("either this or {}, not both", name));
  }
  const bool has_spacings = header.Find("spacings") != nullptr;
  if (maxs == nullptr && !has_spacings) mins->Fail("axis maxs or spacings beside it");
  const glm::dvec3 min = mins->Vector3("three numbers");
  const glm::dvec3 max = maxs != nullptr ? maxs->Vector3("three numbers") : min;
  const std::array<NrrdCentering, 3> centerings = NrrdCenterings(header);
  for (int i = 0; i < 3; ++i) {
    if (maxs != nullptr && !(max[i] > min[i])) {
      maxs->Fail("numbers above those of axis mins: mirrored axes are not read");
    }
    NrrdAxis axis{*mins, min[i], {}, {}, layout.size[i], centerings[size_t(i)]};
    if (maxs != nullptr) axis.max = max[i];
    if (has_spacings) axis.told = layout.spacing[i];
    axis.FindCentering();
    layout.spacing[i] = axis.Spacing();
    const bool is_cell = axis.centering == NrrdCentering::kCell;
    layout.origin[i] = min[i] + (is_cell ? 0.5 * layout.spacing[i] : 0);
  }
}

glm::dvec3 SpacingFromDirections(const Field& field) {
  glm::dvec3 spacing(0.0);
  std::string_view rest = field.text;
  for (int axis = 0; axis < 3; ++axis) {
    const glm::dvec3 direction = NrrdVector(field, rest);
    for (int i = 0; i < 3; ++i) {
      const bool good = i == axis ? direction[i] > 0 : direction[i] == 0;
      if (!good) field.Fail("a diagonal above 0: turned, sheared or mirrored axes are not read");
    }
    spacing[axis] = direction[axis];
  }
  if (!Trimmed(rest).empty()) field.Fail("three vectors");
  return spacing;
}

void ReadNrrdFrame(Header& header, VolumeLayout& layout) {
  const Field* spacings = header.Find("spacings");
  const Field* directions = header.FindAny({"space directions", "spacedirections"});
  if (spacings != nullptr && directions != nullptr) {
    directions->Fail("either this or spacings, not both");
  }
  if (spacings != nullptr) layout.spacing = spacings->Vector3("three numbers");
  if (directions != nullptr) layout.spacing = SpacingFromDirections(*directions);
  if (const Field* origin = header.FindAny({"space origin", "spaceorigin"})) {
    std::string_view rest = origin->text;
    layout.origin = NrrdVector(*origin, rest);
    if (!Trimmed(rest).empty()) origin->Fail("one vector");
  }
  ReadNrrdEnds(header, layout);
}

// A file inside the header's folder.
fs::path InsideFolder(const Field& field) {
  const fs::path path = fs::path(field.text).lexically_normal();
  if (!StaysInside(path)) field.Fail("a file inside the header's folder");
  return path;
}

Placement ReadNrrdPlacement(Header& header, const VolumeLayout& layout) {
  Placement placement;
  const Field& encoding = header.Get("encoding");
  const std::string word = Lower(encoding.text);
  placement.compressed = word == "gzip" || word == "gz";
  if (!placement.compressed && word != "raw") encoding.Fail("raw or gzip");
  if (const Field* file = header.FindAny({"data file", "datafile"})) {
    if (Words(file->text).empty() || file->text.starts_with("LIST") ||
        file->text.find('%') != std::string::npos) {
      file->Fail("the name of one file (lists and patterns of files are not read)");
    }
    placement.data_file = InsideFolder(*file);
  }
  if (const Field* lines = header.FindAny({"line skip", "lineskip"})) {
    if (lines->Integer("a number") != 0) lines->Fail("0; use byte skip");
  }
  if (const Field* bytes = header.FindAny({"byte skip", "byteskip"})) {
    const int64_t skip = bytes->Integer("a number of bytes, or -1 for data at the file's end");
    placement.skip_to_samples = skip == -1;
    if (skip < (placement.compressed ? 0 : -1)) {
      bytes->Fail("a number of bytes of 0 or more, or -1 where the encoding is raw");
    }
    // Of compressed data NRRD counts these behind the unpacking.
    if (skip > 0 && placement.compressed) bytes->Fail("0 where the encoding is gzip");
    if (skip > 0) placement.skip = uint64_t(skip);
  }
  if (const Field* endian = header.Find("endian"); endian != nullptr) {
    const std::string order = Lower(endian->text);
    if (order != "little" && order != "big") endian->Fail("little or big");
  } else if (BytesOf(layout.type) > 1) {
    header.Get("endian");
  }
  return placement;
}

ParsedHeader ParseNrrdHeader(std::span<const uint8_t> bytes, const std::string& name) {
  Lines lines(bytes, name);
  const std::string_view magic = lines.Next().value_or("");
  if (!magic.starts_with("NRRD000") || magic.size() != 8 || magic[7] < '1' || magic[7] > '5') {
    throw DataError(fmt::format("{}: does not begin with NRRD0001 to NRRD0005", name));
  }
  Header header(name);
  while (const std::optional<std::string_view> line = lines.Next()) {
    if (line->empty()) break;  // the samples are next
    if ((*line)[0] == '#') continue;
    const size_t colon = line->find(':');
    if (colon == std::string_view::npos) {
      throw DataError(fmt::format("{}, line {}: is no field (name: value)", name, lines.number()));
    }
    if (colon + 1 < line->size() && (*line)[colon + 1] == '=') continue;  // a note: key:=value
    header.Add(Lower(Trimmed(line->substr(0, colon))), Trimmed(line->substr(colon + 1)),
               lines.number());
  }
  ParsedHeader parsed;
  VolumeLayout& layout = parsed.layout;
  const Field& dimension = header.Get("dimension");
  if (dimension.Integer("a number") != 3) dimension.Fail("3");
  layout.size = header.Get("sizes").Size();
  layout.type = NrrdType(header.Get("type"));
  CheckNrrdKinds(header);
  CheckNrrdSpace(header);
  ReadNrrdFrame(header, layout);
  parsed.placement = ReadNrrdPlacement(header, layout);
  const Field* endian = header.Find("endian");
  layout.big_endian = endian != nullptr && Lower(endian->text) == "big";
  parsed.header_bytes = lines.position();
  parsed.unused_fields = header.Unused();
  return parsed;
}

// --- MetaImage

SampleType MetaType(const Field& field) {
  const std::string& type = field.text;
  if (type == "MET_UCHAR") return SampleType::kUint8;
  if (type == "MET_USHORT") return SampleType::kUint16;
  if (type == "MET_FLOAT") return SampleType::kFloat32;
  field.Fail("MET_UCHAR, MET_USHORT or MET_FLOAT");
}

void RefuseTurnedAxes(const Field& matrix) {
  const std::vector<std::string_view> words = Words(matrix.text);
  if (words.size() != 9) matrix.Fail("nine numbers");
  for (size_t i = 0; i < words.size(); ++i) {
    if (matrix.FiniteFrom(words[i], "nine numbers") != (i % 4 == 0 ? 1 : 0)) {
      matrix.Fail("1 0 0 0 1 0 0 0 1: turned axes are not read");
    }
  }
}

Placement ReadMetaPlacement(Header& header, const Field& data_file) {
  Placement placement;
  if (const Field* binary = header.Find("BinaryData"); binary != nullptr && !binary->Flag()) {
    binary->Fail("True: samples as text are not read");
  }
  if (const Field* compressed = header.Find("CompressedData")) {
    placement.compressed = compressed->Flag();
  }
  header.Find("CompressedDataSize");  // the stream itself tells where it ends
  if (const Field* size = header.Find("HeaderSize")) {
    const int64_t skip = size->Integer("a number of bytes, or -1 for data at the file's end");
    if (skip < -1) size->Fail("a number of bytes, or -1 for data at the file's end");
    placement.skip_to_samples = skip == -1 && !placement.compressed;
    if (skip == -1 && placement.compressed) size->Fail("0 or more where the data is compressed");
    if (skip > 0) placement.skip = uint64_t(skip);
  }
  const bool is_list = data_file.text.starts_with("LIST") ||
                       data_file.text.find('%') != std::string::npos || data_file.text.empty();
  if (is_list) data_file.Fail("LOCAL or one file (lists and patterns of files are not read)");
  if (Lower(data_file.text) != "local") placement.data_file = InsideFolder(data_file);
  return placement;
}

ParsedHeader ParseMetaHeader(std::span<const uint8_t> bytes, const std::string& name) {
  Lines lines(bytes, name);
  Header header(name);
  bool ended = false;  // by ElementDataFile, which is the last field
  while (!ended) {
    const std::optional<std::string_view> line = lines.Next();
    if (!line) break;
    if (line->empty() || (*line)[0] == '#') continue;
    const size_t equals = line->find('=');
    if (equals == std::string_view::npos) {
      throw DataError(fmt::format("{}, line {}: is no field (Name = value)", name, lines.number()));
    }
    const std::string field(Trimmed(line->substr(0, equals)));
    header.Add(field, Trimmed(line->substr(equals + 1)), lines.number());
    ended = field == "ElementDataFile";
  }
  if (const Field* kind = header.Find("ObjectType"); kind != nullptr && kind->text != "Image") {
    kind->Fail("Image");
  }
  const Field& dimensions = header.Get("NDims");
  if (dimensions.Integer("a number") != 3) dimensions.Fail("3");
  const Field* channels = header.Find("ElementNumberOfChannels");
  if (channels != nullptr && channels->Integer("a number") != 1) channels->Fail("1");

  ParsedHeader parsed;
  VolumeLayout& layout = parsed.layout;
  layout.size = header.Get("DimSize").Size();
  layout.type = MetaType(header.Get("ElementType"));
  if (const Field* spacing = header.FindAny({"ElementSpacing", "ElementSize"})) {
    layout.spacing = spacing->Vector3("three numbers");
  }
  if (const Field* origin = header.FindAny({"Offset", "Origin", "Position"})) {
    layout.origin = origin->Vector3("three numbers");
  }
  for (const char* matrix : {"TransformMatrix", "Rotation", "Orientation"}) {
    if (const Field* field = header.Find(matrix)) RefuseTurnedAxes(*field);
  }
  if (const Field* order = header.FindAny({"ElementByteOrderMSB", "BinaryDataByteOrderMSB"})) {
    layout.big_endian = order->Flag();
  }
  parsed.placement = ReadMetaPlacement(header, header.Get("ElementDataFile"));
  parsed.header_bytes = lines.position();
  parsed.unused_fields = header.Unused();
  return parsed;
}

// --- Samples

// Unpacks gzip or zlib data; `size` bytes must come out.
std::vector<uint8_t> Inflate(std::span<const uint8_t> packed, size_t size,
                             const std::string& name) {
  // Deflate packs 1032 bytes into one at best: a claim beyond that takes no memory.
  if (size / 1032 > packed.size()) {
    throw DataError(fmt::format("{}: {} bytes of compressed samples cannot hold {}", name,
                                WithThousands(packed.size()), WithThousands(size)));
  }
  std::vector<uint8_t> unpacked(size);
  z_stream stream{};
  constexpr int kEitherHeader = 15 + 32;
  if (inflateInit2(&stream, kEitherHeader) != Z_OK) throw BugError("zlib does not start");
  constexpr size_t kMaxPart = size_t{1} << 30;  // zlib counts in 32 bits
  size_t read = 0, written = 0;
  int state = Z_OK;
  while (state == Z_OK && written < size) {
    const size_t in = std::min(kMaxPart, packed.size() - read);
    const size_t out = std::min(kMaxPart, size - written);
    stream.next_in = const_cast<Bytef*>(packed.data() + read);
    stream.avail_in = uInt(in);
    stream.next_out = unpacked.data() + written;
    stream.avail_out = uInt(out);
    state = inflate(&stream, Z_NO_FLUSH);
    read += in - stream.avail_in;
    written += out - stream.avail_out;
    if (in == stream.avail_in && out == stream.avail_out) break;  // nothing left to read
  }
  inflateEnd(&stream);
  if (written < size) {
    throw DataError(
        fmt::format("{}: the compressed samples are damaged or end after {} of {} "
                    "bytes",
                    name, WithThousands(written), WithThousands(size)));
  }
  return unpacked;
}

VolumeFile ReadSamples(const fs::path& path, std::vector<uint8_t> file, const ParsedHeader& header,
                       const ValueRange& range) {
  header.layout.Check(path.string());
  VolumeFile result;
  result.type = header.layout.type;
  result.unused_fields = header.unused_fields;
  result.data_file = path;
  const Placement& placement = header.placement;
  size_t begin = header.header_bytes;
  if (!placement.data_file.empty()) {
    result.data_file = path.parent_path() / placement.data_file;
    file = ReadBytes(result.data_file, kMaxFileBytes);
    begin = 0;
  }
  const std::string name = result.data_file.string();
  const size_t size = header.layout.Bytes();
  const size_t available = file.size() - begin;
  if (placement.skip > available) {
    throw DataError(fmt::format("{}: has no sample after its first {} bytes", name,
                                WithThousands(placement.skip)));
  }
  begin += size_t(placement.skip);
  if (placement.skip_to_samples && available >= size) begin = file.size() - size;
  std::span<const uint8_t> samples = std::span(file).subspan(begin);
  if (placement.compressed) {
    const std::vector<uint8_t> unpacked = Inflate(samples, size, name);
    result.volume = DecodeVolume(header.layout, unpacked, name, range);
    return result;
  }
  if (samples.size() > size) {
    LogWarning("{}: {} bytes behind the samples are not read", name,
               WithThousands(samples.size() - size));
  }
  result.volume = DecodeVolume(header.layout, samples, name, range);
  return result;
}

ParsedHeader ParseHeader(const fs::path& path, std::span<const uint8_t> bytes) {
  const std::string extension = Lower(path.extension().string());
  return extension == ".nrrd" || extension == ".nhdr" ? ParseNrrdHeader(bytes, path.string())
                                                      : ParseMetaHeader(bytes, path.string());
}

// Without the samples behind it; one byte more than a header may have shows that it is too long.
ParsedHeader ReadHeader(const fs::path& path) {
  return ParseHeader(path, ReadFront(path, kMaxHeaderBytes + 1));
}

}  // namespace

bool NeedsLayout(const fs::path& path) { return Lower(path.extension().string()) == ".raw"; }

bool IsVolumeFile(const fs::path& path) {
  constexpr std::array kExtensions = {".raw", ".nrrd", ".nhdr", ".mha", ".mhd"};
  const std::string extension = Lower(path.extension().string());
  std::error_code unusable;
  return std::find(kExtensions.begin(), kExtensions.end(), extension) != kExtensions.end() &&
         !fs::is_directory(path, unusable);
}

VolumeFile ReadRawVolume(const fs::path& path, const VolumeLayout& layout,
                         const ValueRange& range) {
  layout.Check(path.string());
  const std::vector<uint8_t> bytes = ReadBytes(path, kMaxFileBytes);
  if (bytes.size() != layout.Bytes()) {
    throw DataError(fmt::format(
        "{}: has {} bytes where {} x {} x {} samples of {} take {}; check --dimensions and "
        "--sample-type",
        path.string(), WithThousands(bytes.size()), layout.size.x, layout.size.y, layout.size.z,
        Name(layout.type), WithThousands(layout.Bytes())));
  }
  return {DecodeVolume(layout, bytes, path.string(), range), layout.type, path, {}};
}

VolumeFile ParseVolume(std::vector<uint8_t> file, const fs::path& path, const ValueRange& range) {
  const ParsedHeader header = ParseHeader(path, file);
  return ReadSamples(path, std::move(file), header, range);
}

VolumeFile ReadVolume(const fs::path& path, const ValueRange& range) {
  return ParseVolume(ReadBytes(path, kMaxFileBytes), path, range);
}

VolumeLayout ReadVolumeLayout(const fs::path& path) {
  const VolumeLayout layout = ReadHeader(path).layout;
  layout.Check(path.string());
  return layout;
}

std::vector<fs::path> FilesNamedByVolume(const fs::path& path) {
  if (!IsVolumeFile(path) || NeedsLayout(path)) return {};
  const fs::path data_file = ReadHeader(path).placement.data_file;
  if (data_file.empty()) return {};
  return {path.parent_path() / data_file};
}

}  // namespace tetrec
