// COLMAP's sparse models as binary files.
#include "colmap/write_model.h"

#include "core/file.h"

#include <glm/gtc/quaternion.hpp>

#include <span>
#include <string>

namespace tetrec {
namespace {

void Write(const Lens& lens, ByteWriter& to) {
  to.Write(int32_t(lens.model));
  to.Write(lens.width);
  to.Write(lens.height);
  to.WriteArray<double>(lens.params);
}

void Write(const ColmapImage& image, ByteWriter& to) {
  const glm::dquat rotation = glm::quat_cast(image.cam_from_world.rotation);
  for (const double part : {rotation.w, rotation.x, rotation.y, rotation.z}) to.Write(part);
  to.Write(image.cam_from_world.translation);
  to.Write(image.camera);
  to.WriteArray<char>(image.name);
  to.Write(char(0));
  to.Write(uint64_t(image.observations.size()));
  for (const ColmapObservation& observation : image.observations) {
    to.Write(observation.pixel);
    to.Write(observation.point);
  }
}

void Write(const ColmapPoint& point, ByteWriter& to) {
  to.Write(point.position);
  to.Write(point.color_srgb);
  to.Write(point.error_px);
  to.Write(uint64_t(point.track.size()));
  for (const ColmapTrackItem& item : point.track) {
    to.Write(item.image);
    to.Write(item.observation);
  }
}

template <class Records>
void WriteRecords(const std::filesystem::path& path, const Records& records) {
  ByteWriter writer;
  writer.Write(uint64_t(records.size()));
  for (const auto& [id, record] : records) {
    writer.Write(id);
    Write(record, writer);
  }
  WriteBytes(path, writer.bytes());
}

}  // namespace

Lens PinholeLens(const Camera& camera) {
  return {LensModel::kPinhole,
          uint64_t(camera.width),
          uint64_t(camera.height),
          {camera.fx, camera.fy, camera.cx, camera.cy}};
}

void WriteColmapModel(const std::filesystem::path& folder, const ColmapModel& model) {
  std::filesystem::create_directories(folder);
  WriteRecords(folder / "cameras.bin", model.cameras);
  WriteRecords(folder / "images.bin", model.images);
  WriteRecords(folder / "points3D.bin", model.points);
}

}  // namespace tetrec
