// COLMAP's sparse models: the reader of the three binary files, and the choice of the files.
#include "colmap/model.h"

#include "colmap/checks.h"
#include "colmap/text.h"
#include "core/error.h"
#include "core/file.h"
#include "core/log.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <set>

namespace tetrec {
namespace fs = std::filesystem;
namespace {

constexpr const char* kParts[] = {"cameras", "images", "points3D"};
constexpr uint64_t kMaxTextBytes = uint64_t{1} << 33;

constexpr size_t kMaxNameBytes = 4096;

// The smallest records: a camera with 3 parameters, an image without name and observations, a point
// without track.
constexpr uint64_t kMinCameraBytes = 24 + 3 * 8, kMinImageBytes = 73, kMinPointBytes = 51;
constexpr uint64_t kObservationBytes = 24, kTrackItemBytes = 8;

[[noreturn]] void Fail(const ByteReader& reader, const std::string& what) {
  throw DataError(fmt::format("{}: byte {}: {}", reader.name(), reader.position(), what));
}

void FailOn(const ByteReader& reader, const std::string& complaint) {
  if (!complaint.empty()) Fail(reader, complaint);
}

double ReadFinite(ByteReader& reader, const char* what) {
  const auto value = reader.Read<double>(what);
  if (!internal::IsSane(value)) Fail(reader, fmt::format("{} is {}", what, value));
  return value;
}

glm::dvec3 ReadFinite3(ByteReader& reader, const char* what) {
  const double x = ReadFinite(reader, what), y = ReadFinite(reader, what);
  return {x, y, ReadFinite(reader, what)};
}

std::string ReadName(ByteReader& reader) {
  std::string name;
  while (const char c = reader.Read<char>("the end of an image's name")) {
    name += c;
    if (name.size() > kMaxNameBytes) Fail(reader, "an image's name does not end");
  }
  FailOn(reader, internal::ComplaintOnImageName(name));
  return name;
}

Lens ReadLens(ByteReader& reader) {
  Lens lens;
  const auto model = reader.Read<int32_t>("a camera model");
  lens.model = LensModel(model);
  if (!IsKnown(lens.model)) {
    Fail(reader, internal::ComplaintOnUnknownModel(fmt::to_string(model)));
  }
  lens.width = reader.Read<uint64_t>("a width");
  lens.height = reader.Read<uint64_t>("a height");
  FailOn(reader, internal::ComplaintOnSize(lens.width, lens.height));
  for (int i = 0; i < ParamCount(lens.model); ++i) {
    lens.params.push_back(ReadFinite(reader, "a camera parameter"));
  }
  FailOn(reader, ComplaintOnLens(lens));
  return lens;
}

Rigid3 ReadPose(ByteReader& reader) {
  double wxyz[4];
  for (double& component : wxyz) component = ReadFinite(reader, "a rotation");
  FailOn(reader, internal::ComplaintOnQuaternion(wxyz));
  return internal::PoseOf(wxyz, ReadFinite3(reader, "a translation"));
}

ColmapImage ReadImageRecord(ByteReader& reader) {
  ColmapImage image;
  image.cam_from_world = ReadPose(reader);
  image.camera = reader.Read<uint32_t>("a camera id");
  image.name = ReadName(reader);
  const auto count = reader.Read<uint64_t>("an observation count");
  reader.CheckCount(count, kObservationBytes, "observations");
  image.observations.resize(count);
  for (ColmapObservation& observation : image.observations) {
    const double x = ReadFinite(reader, "an observation");
    observation.pixel = {x, ReadFinite(reader, "an observation")};
    observation.point = reader.Read<uint64_t>("a point id");
  }
  return image;
}

ColmapPoint ReadPoint(ByteReader& reader) {
  ColmapPoint point;
  point.position = ReadFinite3(reader, "a point");
  point.color_srgb = reader.Read<std::array<uint8_t, 3>>("a colour");
  point.error_px = ReadFinite(reader, "a reprojection error");
  if (point.error_px < 0) point.error_px = 0;  // -1: COLMAP has not computed it
  const auto length = reader.Read<uint64_t>("a track length");
  reader.CheckCount(length, kTrackItemBytes, "track items");
  point.track.resize(length);
  for (ColmapTrackItem& item : point.track) {
    item.image = reader.Read<uint32_t>("a track's image");
    item.observation = reader.Read<uint32_t>("a track's observation");
  }
  return point;
}

template <class Id, class Record>
std::map<Id, Record> ReadRecords(std::span<const uint8_t> bytes, const std::string& name,
                                 uint64_t min_bytes, const char* what,
                                 Record (*read)(ByteReader&)) {
  ByteReader reader(bytes, name);
  const auto count = reader.Read<uint64_t>("a count");
  reader.CheckCount(count, min_bytes, what);
  std::map<Id, Record> records;
  for (uint64_t i = 0; i < count; ++i) {
    const auto id = reader.Read<Id>("an id");
    if (!records.emplace(id, read(reader)).second)
      Fail(reader, fmt::format("the id {} comes twice among the {}", id, what));
  }
  reader.ExpectEnd();
  return records;
}

bool HasObservation(const ColmapModel& model, const ColmapTrackItem& item) {
  const auto image = model.images.find(item.image);
  return image != model.images.end() && item.observation < image->second.observations.size();
}

bool SeesNothing(const ColmapModel& model, const ColmapObservation& observation) {
  return observation.point != kNoColmapPoint && !model.points.contains(observation.point);
}

}  // namespace

std::map<uint32_t, Lens> ParseColmapCameras(std::span<const uint8_t> bytes,
                                            const std::string& name) {
  return ReadRecords<uint32_t>(bytes, name, kMinCameraBytes, "cameras", &ReadLens);
}

std::map<uint32_t, ColmapImage> ParseColmapImages(std::span<const uint8_t> bytes,
                                                  const std::string& name) {
  return ReadRecords<uint32_t>(bytes, name, kMinImageBytes, "images", &ReadImageRecord);
}

std::map<uint64_t, ColmapPoint> ParseColmapPoints(std::span<const uint8_t> bytes,
                                                  const std::string& name) {
  return ReadRecords<uint64_t>(bytes, name, kMinPointBytes, "points", &ReadPoint);
}

void CheckColmapModel(const ColmapModel& model, const std::string& name) {
  std::set<std::string> names;
  for (const auto& [id, image] : model.images) {
    if (!names.insert(image.name).second) {
      throw DataError(fmt::format("{}: two images have the name {}", name, image.name));
    }
    if (!model.cameras.contains(image.camera)) {
      throw DataError(fmt::format("{}: image {} has camera {}, which does not exist", name,
                                  image.name, image.camera));
    }
    const Lens& lens = model.cameras.at(image.camera);
    if (lens.model == LensModel::kUnknown) {
      throw DataError(fmt::format("{}: image {} has camera {}: {}", name, image.name, image.camera,
                                  internal::ComplaintOnUnknownModel(lens.unknown_model)));
    }
    for (const ColmapObservation& observation : image.observations) {
      if (SeesNothing(model, observation)) {
        throw DataError(fmt::format("{}: image {} sees point {}, which does not exist", name,
                                    image.name, observation.point));
      }
    }
  }
  for (const auto& [id, point] : model.points) {
    for (const ColmapTrackItem& item : point.track) {
      if (!HasObservation(model, item)) {
        throw DataError(
            fmt::format("{}: point {} is seen as observation {} of image {}, which does not exist",
                        name, id, item.observation, item.image));
      }
    }
  }
}

size_t DropDanglingReferences(ColmapModel& model) {
  size_t dropped = 0;
  for (auto& [id, image] : model.images) {
    for (ColmapObservation& observation : image.observations) {
      if (!SeesNothing(model, observation)) continue;
      observation.point = kNoColmapPoint;
      ++dropped;
    }
  }
  for (auto& [id, point] : model.points) {
    dropped += std::erase_if(
        point.track, [&](const ColmapTrackItem& item) { return !HasObservation(model, item); });
  }
  return dropped;
}

ColmapModel ReadColmapModel(const fs::path& folder, DanglingReferences dangling) {
  // Three files of one kind. If both kinds are complete, COLMAP itself prefers the binary files.
  const auto has = [&](const char* extension) {
    return std::all_of(std::begin(kParts), std::end(kParts), [&](const char* part) {
      return fs::exists(folder / (std::string(part) + extension));
    });
  };
  const bool binary = has(".bin"), text = has(".txt");
  if (!binary && !text) {
    throw DataError(
        fmt::format("{}: no complete COLMAP model; expected cameras, images and points3D, all .bin "
                    "or all .txt",
                    folder.string()));
  }
  if (binary && text) {
    LogInfo("{}: the model exists as binary files and as text; the binary files are read",
            folder.string());
  }
  ColmapModel model;
  const auto parse = [&](const char* part, auto& into, auto&& of_binary, auto&& of_text) {
    const fs::path path = folder / (std::string(part) + (binary ? ".bin" : ".txt"));
    into = binary ? of_binary(ReadBytes(path), path.string())
                  : of_text(ReadText(path, kMaxTextBytes), path.string());
  };
  parse(kParts[0], model.cameras, ParseColmapCameras, ParseColmapCamerasText);
  parse(kParts[1], model.images, ParseColmapImages, ParseColmapImagesText);
  parse(kParts[2], model.points, ParseColmapPoints, ParseColmapPointsText);
  const size_t dropped = dangling == DanglingReferences::kDrop ? DropDanglingReferences(model) : 0;
  if (dropped > 0) {
    LogWarning(
        "{}: observations and track items that refer to nothing that exists, as after points or "
        "images were removed: {}; left out",
        folder.string(), dropped);
  }
  CheckColmapModel(model, folder.string());
  std::erase_if(model.cameras,
                [](const auto& camera) { return camera.second.model == LensModel::kUnknown; });
  return model;
}

double MeanReprojectionError_px(const ColmapModel& model) {
  double sum = 0;
  for (const auto& [id, point] : model.points) sum += point.error_px;
  return model.points.empty() ? 0 : sum / double(model.points.size());
}

double MeanTrackLength(const ColmapModel& model) {
  double sum = 0;
  for (const auto& [id, point] : model.points) sum += double(point.track.size());
  return model.points.empty() ? 0 : sum / double(model.points.size());
}

}  // namespace tetrec
