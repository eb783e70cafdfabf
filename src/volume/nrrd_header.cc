// Headers of NRRD files. Source: teem's "Definition of NRRD File Format".
#include "core/error.h"
#include "core/lower_case.h"
#include "volume/header.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace tetrec::internal {
namespace {

SampleType NrrdType(const HeaderField& field) {
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
      {"short", SampleType::kInt16},
      {"short int", SampleType::kInt16},
      {"signed short", SampleType::kInt16},
      {"signed short int", SampleType::kInt16},
      {"int16", SampleType::kInt16},
      {"int16_t", SampleType::kInt16},
      {"float", SampleType::kFloat32}};
  std::string spelling;
  for (const std::string_view word : Words(field.text)) {
    if (!spelling.empty()) spelling += ' ';
    spelling += Lower(word);
  }
  const auto found = kTypes.find(spelling);
  if (found == kTypes.end())
    field.Fail("uint8, uint16, int16 or float; convert the samples to one of these");
  return found->second;
}

// Reads a vector like "(a,b,c)" and removes it from the text.
glm::dvec3 NrrdVector(const HeaderField& field, std::string_view& text) {
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

// Refuses axes along which the samples are not places in space.
void CheckNrrdKinds(VolumeHeader& header) {
  const HeaderField* kinds = header.Find("kinds");
  if (kinds == nullptr) return;
  const auto is_place = [](std::string_view word) {
    const std::string kind = Lower(word);
    return kind == "space" || kind == "domain" || kind == "none" || kind == "???";
  };
  const std::vector<std::string_view> words = Words(kinds->text);
  if (words.size() != 3 || !std::all_of(words.begin(), words.end(), is_place)) {
    kinds->Fail(
        "space, domain or none for each of the three axes; colours, vectors, times and other lists "
        "are not supported");
  }
}

// Only the handedness matters: a left-handed space would be mirrored. Names are written with
// hyphens, with spaces, or without either.
void CheckNrrdSpace(VolumeHeader& header) {
  static const std::set<std::string> kRightHanded = {
      "rightanteriorsuperior", "ras", "leftposteriorsuperior", "lps", "scannerxyz",
      "3drighthanded"};
  static const std::set<std::string> kLeftHanded = {"leftanteriorsuperior", "las", "3dlefthanded"};
  const HeaderField* dimension = header.FindAny({"space dimension", "spacedimension"});
  if (dimension != nullptr && dimension->Integer("a number") != 3) dimension->Fail("3");
  const HeaderField* space = header.Find("space");
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

// The ends of an axis are the places of its outermost samples, or the far sides of their cells.
enum class NrrdCentering { kUnknown, kNode, kCell };

std::array<NrrdCentering, 3> NrrdCenterings(VolumeHeader& header) {
  std::array<NrrdCentering, 3> centerings{};
  const HeaderField* field = header.FindAny({"centerings", "centers"});
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

// One axis as given by its ends. `max` and `spacing` are set if the header has axis maxs and
// spacings.
struct NrrdAxis {
  const HeaderField& mins;
  double min;
  std::optional<double> max, spacing;
  int samples;
  NrrdCentering centering;

  // The number of spacings from one end to the other.
  double Steps() const { return samples - (centering == NrrdCentering::kCell ? 0 : 1); }
  // The definition leaves an unspecified centering open; teem assumes cells, others nodes. Spacings
  // decide if both ends are given.
  void FindCentering() {
    if (centering != NrrdCentering::kUnknown) return;
    if (!max || !spacing) {
      mins.Fail("centerings beside it, node or cell for each axis, which define what its ends are");
    }
    centering =
        (*max - min) / *spacing > samples - 0.5 ? NrrdCentering::kCell : NrrdCentering::kNode;
  }
  double Spacing() const {
    if (!max) return *spacing;
    const double from_ends = (*max - min) / Steps();
    if (!spacing) return from_ends;
    // Spacings are often rounded. Node instead of cell would make a difference of a whole step.
    constexpr double kMostSteps = 0.25;
    if (!(std::abs((*max - min) / *spacing - Steps()) <= kMostSteps)) {
      mins.Fail(fmt::format(
          "ends that agree with spacings: along an axis these are {}, axis mins and maxs give {}",
          *spacing, from_ends));
    }
    return *spacing;
  }
};

// Spacing and origin from axis mins and maxs.
void ReadNrrdEnds(VolumeHeader& header, VolumeLayout& layout) {
  const HeaderField* mins = header.FindAny({"axis mins", "axismins"});
  const HeaderField* maxs = header.FindAny({"axis maxs", "axismaxs"});
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
      maxs->Fail("numbers above those of axis mins: mirrored axes are not supported");
    }
    NrrdAxis axis{*mins, min[i], {}, {}, layout.size[i], centerings[size_t(i)]};
    if (maxs != nullptr) axis.max = max[i];
    if (has_spacings) axis.spacing = layout.spacing[i];
    axis.FindCentering();
    layout.spacing[i] = axis.Spacing();
    const bool is_cell = axis.centering == NrrdCentering::kCell;
    layout.origin[i] = min[i] + (is_cell ? 0.5 * layout.spacing[i] : 0);
  }
}

glm::dvec3 SpacingFromDirections(const HeaderField& field) {
  glm::dvec3 spacing(0.0);
  std::string_view rest = field.text;
  for (int axis = 0; axis < 3; ++axis) {
    const glm::dvec3 direction = NrrdVector(field, rest);
    for (int i = 0; i < 3; ++i) {
      constexpr double kRounding = 1e-6;  // of the rotations that exporters write
      const bool good =
          i == axis ? direction[i] > 0 : std::abs(direction[i]) <= kRounding * direction[axis];
      if (!good)
        field.Fail("a diagonal above 0: rotated, sheared or mirrored axes are not supported");
    }
    spacing[axis] = direction[axis];
  }
  if (!Trimmed(rest).empty()) field.Fail("three vectors");
  return spacing;
}

void ReadNrrdFrame(VolumeHeader& header, VolumeLayout& layout) {
  const HeaderField* spacings = header.Find("spacings");
  const HeaderField* directions = header.FindAny({"space directions", "spacedirections"});
  if (spacings != nullptr && directions != nullptr) {
    directions->Fail("either this or spacings, not both");
  }
  if (spacings != nullptr) layout.spacing = spacings->Vector3("three numbers");
  if (directions != nullptr) layout.spacing = SpacingFromDirections(*directions);
  if (const HeaderField* origin = header.FindAny({"space origin", "spaceorigin"})) {
    std::string_view rest = origin->text;
    layout.origin = NrrdVector(*origin, rest);
    if (!Trimmed(rest).empty()) origin->Fail("one vector");
  }
  ReadNrrdEnds(header, layout);
}

SamplePlacement ReadNrrdPlacement(VolumeHeader& header, const VolumeLayout& layout) {
  SamplePlacement placement;
  const HeaderField& encoding = header.Get("encoding");
  const std::string word = Lower(encoding.text);
  placement.compressed = word == "gzip" || word == "gz";
  if (!placement.compressed && word != "raw") encoding.Fail("raw or gzip");
  if (const HeaderField* file = header.FindAny({"data file", "datafile"})) {
    if (Words(file->text).empty() || file->text.starts_with("LIST") ||
        file->text.find('%') != std::string::npos) {
      file->Fail("the name of one file (lists and patterns of files are not supported)");
    }
    placement.data_file = file->FileInside();
  }
  if (const HeaderField* lines = header.FindAny({"line skip", "lineskip"})) {
    if (lines->Integer("a number") != 0) lines->Fail("0; use byte skip");
  }
  if (const HeaderField* bytes = header.FindAny({"byte skip", "byteskip"})) {
    const int64_t skip = bytes->Integer("a number of bytes, or -1 for data at the end of the file");
    placement.skip_to_samples = skip == -1;
    if (skip < (placement.compressed ? 0 : -1)) {
      bytes->Fail("0 or more bytes, or -1 if the encoding is raw");
    }
    // NRRD counts these in the decompressed data.
    if (skip > 0 && placement.compressed) bytes->Fail("0 if the encoding is gzip");
    if (skip > 0) placement.skip = uint64_t(skip);
  }
  if (const HeaderField* endian = header.Find("endian"); endian != nullptr) {
    const std::string order = Lower(endian->text);
    if (order != "little" && order != "big") endian->Fail("little or big");
  } else if (BytesOf(layout.type) > 1) {
    header.Get("endian");
  }
  return placement;
}

}  // namespace

ParsedVolumeHeader ParseNrrdHeader(std::span<const uint8_t> bytes, const std::string& name) {
  HeaderLines lines(bytes, name);
  const std::string_view magic = lines.Next().value_or("");
  if (!magic.starts_with("NRRD000") || magic.size() != 8 || magic[7] < '1' || magic[7] > '5') {
    throw DataError(fmt::format("{}: does not start with NRRD0001 to NRRD0005", name));
  }
  VolumeHeader header(name);
  while (const std::optional<std::string_view> line = lines.Next()) {
    if (line->empty()) break;  // the samples follow
    if ((*line)[0] == '#') continue;
    const size_t colon = line->find(':');
    if (colon == std::string_view::npos) {
      throw DataError(
          fmt::format("{}, line {}: is not a field (name: value)", name, lines.number()));
    }
    if (colon + 1 < line->size() && (*line)[colon + 1] == '=') continue;  // a key:=value pair
    header.Add(Lower(Trimmed(line->substr(0, colon))), Trimmed(line->substr(colon + 1)),
               lines.number());
  }
  ParsedVolumeHeader parsed;
  VolumeLayout& layout = parsed.layout;
  const HeaderField& dimension = header.Get("dimension");
  if (dimension.Integer("a number") != 3) dimension.Fail("3");
  layout.size = header.Get("sizes").Size();
  layout.type = NrrdType(header.Get("type"));
  CheckNrrdKinds(header);
  CheckNrrdSpace(header);
  ReadNrrdFrame(header, layout);
  parsed.placement = ReadNrrdPlacement(header, layout);
  const HeaderField* endian = header.Find("endian");
  layout.big_endian = endian != nullptr && Lower(endian->text) == "big";
  parsed.header_bytes = lines.position();
  parsed.unused_fields = header.Unused();
  return parsed;
}

}  // namespace tetrec::internal
