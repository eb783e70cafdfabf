// COLMAP's sparse models as text, line by line.
#include "colmap/text.h"

#include "colmap/checks.h"
#include "core/error.h"

#include <fmt/format.h>

#include <charconv>
#include <utility>

namespace tetrec {
namespace {

constexpr std::string_view kBlanks = " \t\r";
constexpr size_t kShown = 40;  // bytes of a wrong word that a message quotes

std::string_view Trimmed(std::string_view line) {
  const size_t first = line.find_first_not_of(kBlanks);
  if (first == line.npos) return {};
  return line.substr(first, line.find_last_not_of(kBlanks) - first + 1);
}

// The words of a file, line by line.
class TextReader {
 public:
  TextReader(std::string_view text, const std::string& name) : rest_(text), name_(name) {}

  // Moves to the next line, whatever it contains; false at the end.
  bool NextLine() {
    if (rest_.empty()) return false;
    const size_t end = rest_.find('\n');
    line_ = Trimmed(rest_.substr(0, end));
    rest_ = end == rest_.npos ? std::string_view() : rest_.substr(end + 1);
    ++number_;
    return true;
  }
  // Moves to the next line that is neither empty nor a comment.
  bool NextRecord() {
    while (NextLine()) {
      if (!line_.empty() && line_[0] != '#') return true;
    }
    return false;
  }

  bool AtEndOfLine() const { return line_.empty(); }

  std::string_view Word(const char* what) {
    if (line_.empty()) Fail(fmt::format("ends where {} was expected", what));
    const size_t end = line_.find_first_of(kBlanks);
    const std::string_view word = line_.substr(0, end);
    line_ = end == line_.npos ? std::string_view() : Trimmed(line_.substr(end));
    return word;
  }
  template <class Integer>
  Integer Whole(const char* what) {
    return Parsed<Integer>(what, "an integer");
  }
  double Number(const char* what) {
    const auto value = Parsed<double>(what, "a number");
    if (!internal::IsSane(value)) Fail(fmt::format("{} is {}", what, value));
    return value;
  }
  glm::dvec3 Vector(const char* what) {
    const double x = Number(what), y = Number(what);
    return {x, y, Number(what)};
  }
  std::string RestOfLine() { return std::string(std::exchange(line_, {})); }

  void ExpectEndOfLine() const {
    if (!line_.empty()) Fail(fmt::format("continues with \"{}\"", line_.substr(0, kShown)));
  }
  void FailOn(const std::string& complaint) const {
    if (!complaint.empty()) Fail(complaint);
  }
  [[noreturn]] void Fail(const std::string& what) const {
    throw DataError(fmt::format("{}: line {}: {}", name_, number_, what));
  }

 private:
  template <class Value>
  Value Parsed(const char* what, const char* kind) {
    const std::string_view word = Word(what);
    Value value{};
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size()) {
      Fail(fmt::format("{} is \"{}\"; expected {}", what, word.substr(0, kShown), kind));
    }
    return value;
  }

  std::string_view rest_, line_;
  std::string name_;
  size_t number_ = 0;
};

Lens ReadLens(TextReader& reader) {
  Lens lens;
  const std::string_view model = reader.Word("a camera model");
  lens.model = FromName<LensModel>(model).value_or(LensModel::kUnknown);
  lens.width = reader.Whole<uint64_t>("a width");
  lens.height = reader.Whole<uint64_t>("a height");
  reader.FailOn(internal::ComplaintOnSize(lens.width, lens.height));
  if (lens.model == LensModel::kUnknown) {  // bad only if an image has this camera
    lens.unknown_model = fmt::format("\"{}\"", model.substr(0, kShown));
    reader.RestOfLine();
    return lens;
  }
  for (int i = 0; i < ParamCount(lens.model); ++i) {
    lens.params.push_back(reader.Number("a camera parameter"));
  }
  reader.FailOn(ComplaintOnLens(lens));
  reader.ExpectEndOfLine();
  return lens;
}

// X Y POINT3D_ID; the id is -1 if the feature belongs to no point.
ColmapObservation ReadObservation(TextReader& reader) {
  ColmapObservation observation;
  const double x = reader.Number("an observation's x");
  observation.pixel = {x, reader.Number("an observation's y")};
  const auto point = reader.Whole<int64_t>("an observation's point");
  if (point < -1) reader.Fail(fmt::format("an observation's point is {}", point));
  observation.point = point < 0 ? kNoColmapPoint : uint64_t(point);
  return observation;
}

// Two lines: the pose, and the observations.
ColmapImage ReadImageRecord(TextReader& reader) {
  ColmapImage image;
  double wxyz[4];
  for (double& component : wxyz) component = reader.Number("a rotation");
  reader.FailOn(internal::ComplaintOnQuaternion(wxyz));
  image.cam_from_world = internal::PoseOf(wxyz, reader.Vector("a translation"));
  image.camera = reader.Whole<uint32_t>("a camera id");
  image.name = reader.RestOfLine();
  reader.FailOn(internal::ComplaintOnImageName(image.name));
  if (!reader.NextLine()) return image;
  while (!reader.AtEndOfLine()) image.observations.push_back(ReadObservation(reader));
  return image;
}

ColmapPoint ReadPoint(TextReader& reader) {
  ColmapPoint point;
  point.position = reader.Vector("a point");
  for (uint8_t& channel : point.color_srgb) channel = reader.Whole<uint8_t>("a colour");
  point.error_px = reader.Number("a reprojection error");
  if (point.error_px < 0) point.error_px = 0;  // -1: COLMAP has not computed it
  while (!reader.AtEndOfLine()) {
    ColmapTrackItem item;
    item.image = reader.Whole<uint32_t>("a track's image");
    item.observation = reader.Whole<uint32_t>("a track's observation");
    point.track.push_back(item);
  }
  return point;
}

template <class Id, class Record>
std::map<Id, Record> ReadRecords(std::string_view text, const std::string& name, const char* what,
                                 Record (*read)(TextReader&)) {
  TextReader reader(text, name);
  std::map<Id, Record> records;
  while (reader.NextRecord()) {
    const Id id = reader.Whole<Id>("an id");
    if (!records.emplace(id, read(reader)).second)
      reader.Fail(fmt::format("the id {} comes twice among the {}", id, what));
  }
  return records;
}

}  // namespace

std::map<uint32_t, Lens> ParseColmapCamerasText(std::string_view text, const std::string& name) {
  return ReadRecords<uint32_t>(text, name, "cameras", &ReadLens);
}

std::map<uint32_t, ColmapImage> ParseColmapImagesText(std::string_view text,
                                                      const std::string& name) {
  return ReadRecords<uint32_t>(text, name, "images", &ReadImageRecord);
}

std::map<uint64_t, ColmapPoint> ParseColmapPointsText(std::string_view text,
                                                      const std::string& name) {
  return ReadRecords<uint64_t>(text, name, "points", &ReadPoint);
}

}  // namespace tetrec
