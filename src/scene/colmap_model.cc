// COLMAP's sparse models: a careful reader of the three binary files.
#include "scene/colmap_model.h"

#include "core/error.h"
#include "core/file.h"
#include "scene/checked_json.h"

#include <fmt/format.h>

#include <cmath>

namespace tetrec {
namespace {

// Parameters of SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, OPENCV_FISHEYE,
// FULL_OPENCV, FOV, SIMPLE_RADIAL_FISHEYE, RADIAL_FISHEYE and THIN_PRISM_FISHEYE.
constexpr int kParamCounts[] = {3, 4, 4, 5, 8, 8, 12, 5, 4, 5, 12};
constexpr int kModelCount = int(std::size(kParamCounts));
constexpr uint64_t kMaxSide_px = 1 << 16;
constexpr size_t kMaxNameBytes = 4096;
constexpr double kFarthest = 1e12;  // more is a number gone astray, though finite

// Smallest records: a camera with 3 parameters, an image without name and observations, a point
// without track.
constexpr uint64_t kMinCameraBytes = 24 + 3 * 8, kMinImageBytes = 73, kMinPointBytes = 51;
constexpr uint64_t kObservationBytes = 24, kTrackItemBytes = 8;

[[noreturn]] void Fail(const ByteReader& reader, const std::string& what) {
  throw DataError(fmt::format("{}: byte {}: {}", reader.name(), reader.position(), what));
}

double ReadFinite(ByteReader& reader, const char* what) {
  const auto value = reader.Read<double>(what);
  if (!(std::abs(value) <= kFarthest)) Fail(reader, fmt::format("{} is {}", what, value));
  return value;
}

glm::dvec3 ReadFinite3(ByteReader& reader, const char* what) {
  const double x = ReadFinite(reader, what), y = ReadFinite(reader, what);
  return {x, y, ReadFinite(reader, what)};
}

std::string ReadName(ByteReader& reader) {
  std::string name;
  while (const char c = reader.Read<char>("the end of a picture's name")) {
    name += c;
    if (name.size() > kMaxNameBytes) Fail(reader, "a picture's name does not end");
  }
  // Files are written under these names.
  if (!StaysInside(name))
    Fail(reader, fmt::format("the picture name \"{}\" is no relative path", name));
  return name;
}

ColmapCamera ReadCamera(ByteReader& reader) {
  ColmapCamera camera;
  camera.model = reader.Read<int32_t>("a camera model");
  if (camera.model < 0 || camera.model >= kModelCount) {
    Fail(reader,
         fmt::format("camera model {} is not known (0 to {})", camera.model, kModelCount - 1));
  }
  camera.width = reader.Read<uint64_t>("a width");
  camera.height = reader.Read<uint64_t>("a height");
  if (std::min(camera.width, camera.height) < 1 ||
      std::max(camera.width, camera.height) > kMaxSide_px) {
    Fail(reader, fmt::format("a camera has {} x {} pixels", camera.width, camera.height));
  }
  for (int i = 0; i < kParamCounts[camera.model]; ++i) {
    camera.params.push_back(ReadFinite(reader, "a camera parameter"));
  }
  return camera;
}

Rigid3 ReadPose(ByteReader& reader) {
  double q[4];  // w, x, y, z
  double squared = 0;
  for (double& component : q) {
    component = ReadFinite(reader, "a rotation");
    squared += component * component;
  }
  constexpr double kTolerance = 1e-3;  // COLMAP normalises; what is further off is no rotation
  if (std::abs(squared - 1) > kTolerance)
    Fail(reader, fmt::format("a quaternion has the squared length {}", squared));
  Rigid3 pose;
  pose.rotation = glm::mat3_cast(glm::normalize(glm::dquat(q[0], q[1], q[2], q[3])));
  pose.translation = ReadFinite3(reader, "a translation");
  return pose;
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

void CheckReferences(const ColmapModel& model, const std::string& folder) {
  for (const auto& [id, image] : model.images) {
    if (!model.cameras.contains(image.camera)) {
      throw DataError(fmt::format("{}: image {} has camera {}, which does not exist", folder,
                                  image.name, image.camera));
    }
    for (const ColmapObservation& observation : image.observations) {
      if (observation.point != kNoColmapPoint && !model.points.contains(observation.point)) {
        throw DataError(fmt::format("{}: image {} sees point {}, which does not exist", folder,
                                    image.name, observation.point));
      }
    }
  }
  for (const auto& [id, point] : model.points) {
    for (const ColmapTrackItem& item : point.track) {
      const auto image = model.images.find(item.image);
      if (image == model.images.end() || item.observation >= image->second.observations.size()) {
        throw DataError(
            fmt::format("{}: point {} is seen as observation {} of image {}, which does not exist",
                        folder, id, item.observation, item.image));
      }
    }
  }
}

}  // namespace

std::map<uint32_t, ColmapCamera> ParseColmapCameras(std::span<const uint8_t> bytes,
                                                    const std::string& name) {
  return ReadRecords<uint32_t>(bytes, name, kMinCameraBytes, "cameras", &ReadCamera);
}

std::map<uint32_t, ColmapImage> ParseColmapImages(std::span<const uint8_t> bytes,
                                                  const std::string& name) {
  return ReadRecords<uint32_t>(bytes, name, kMinImageBytes, "images", &ReadImageRecord);
}

std::map<uint64_t, ColmapPoint> ParseColmapPoints(std::span<const uint8_t> bytes,
                                                  const std::string& name) {
  return ReadRecords<uint64_t>(bytes, name, kMinPointBytes, "points", &ReadPoint);
}

ColmapModel ReadColmapModel(const std::filesystem::path& folder) {
  const auto parse = [&](const char* file, auto&& parser) {
    const std::filesystem::path path = folder / file;
    return parser(ReadBytes(path), path.string());
  };
  ColmapModel model;
  model.cameras = parse("cameras.bin", ParseColmapCameras);
  model.images = parse("images.bin", ParseColmapImages);
  model.points = parse("points3D.bin", ParseColmapPoints);
  CheckReferences(model, folder.string());
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
