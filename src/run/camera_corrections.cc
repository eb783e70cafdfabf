// Writes and reads cameras.json (schema 1).
#include "run/camera_corrections.h"

#include "core/error_context.h"
#include "core/file.h"
#include "geometry/checked_geometry.h"
#include "run/named_views.h"

#include <fmt/format.h>

namespace tetrec {
namespace {

using nlohmann::json;

constexpr double kLargestMove = 1e6, kLargestShift_px = 1e6;
constexpr double kRotationTolerance = 1e-6;

Rigid3 ReadPose(const CheckedJson& field) {
  const CheckedJson rotation = field.Field("rotation");
  return {CheckedRotation(rotation.Matrix3(), kRotationTolerance, rotation),
          field.Field("translation").Vector3()};
}

}  // namespace

void WriteCameraCorrections(const std::filesystem::path& path,
                            const std::vector<CameraCorrection>& corrections) {
  json views = json::array();
  for (const CameraCorrection& correction : corrections) {
    const Rigid3& pose = correction.cam_from_world;
    views.push_back(
        {{"name", correction.name},
         {"rotation_deg", correction.rotation_deg},
         {"move", correction.move},
         {"shift_px", correction.shift_px},
         {"cam_from_world",
          {{"rotation", ToJson(pose.rotation)}, {"translation", ToJson(pose.translation)}}}});
  }
  const json value = NamedViewsFile(std::move(views));
  ParseCameraCorrections(value, path.string());
  WriteJson(path, value);
}

std::vector<CameraCorrection> ParseCameraCorrections(const json& value, const std::string& name) {
  std::vector<CameraCorrection> corrections;
  for (const CheckedJson& view : NamedViews(CheckedJson(value, name))) {
    corrections.push_back({view.Field("name").Text(), ReadPose(view.Field("cam_from_world")),
                           view.Field("rotation_deg").NumberIn(0, 180),
                           view.Field("move").NumberIn(0, kLargestMove),
                           view.Field("shift_px").NumberIn(0, kLargestShift_px)});
  }
  return corrections;
}

std::vector<CameraCorrection> ReadCameraCorrections(const std::filesystem::path& path) {
  return Advising("run tetrec-optimize again",
                  [&] { return ParseCameraCorrections(ReadJson(path), path.string()); });
}

bool MovedMuch(const CameraCorrection& correction) { return correction.shift_px > kMovedMuch_px; }

std::string MovedMuchWarning(size_t moved, size_t cameras) {
  return fmt::format(
      "{} of {} cameras were wrong by so much that their pictures moved by more than {:.1f} px "
      "when "
      "they were corrected; cameras from sharper or more photos would be better",
      moved, cameras, kMovedMuch_px);
}

}  // namespace tetrec
