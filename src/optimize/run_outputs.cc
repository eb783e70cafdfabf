// What a run writes beside the field.
#include "optimize/run_outputs.h"

#include "core/log.h"
#include "core/short_list.h"
#include "geometry/small_motion.h"
#include "run/camera_corrections.h"
#include "run/field_world.h"
#include "run/left_out_photos.h"
#include "run/photo_exposures.h"

#include <algorithm>

namespace tetrec {
namespace {

namespace fs = std::filesystem;

CameraCorrection CorrectionOf(const std::string& name, const RenderView& given,
                              const CorrectedPose& pose) {
  const Rigid3 motion = pose.cam_from_world * given.cam_from_world.Inverse();
  return {name, pose.cam_from_world, glm::degrees(glm::length(RotationVector(motion.rotation))),
          glm::length(motion.Inverse().translation),
          pose.depth > 0 ? PictureShift(given.camera, motion, pose.depth) : 0};
}

}  // namespace

void WriteExposures(const Scene& scene, std::span<const ViewExposure> exposures,
                    std::span<const uint8_t> left_out, Stage& stage) {
  if (exposures.empty()) return;
  const std::vector<int> views = scene.ViewsOf(Split::kTrain);
  std::vector<PhotoExposure> rows;
  for (size_t i = 0; i < exposures.size(); ++i) {
    if (!left_out.empty() && left_out[i]) continue;
    rows.push_back({scene.views[size_t(views[i])].name, exposures[i].gain, exposures[i].offset});
  }
  WritePhotoExposures(stage.Output(kPhotoExposuresFile), rows);
  const auto uneven = std::count_if(rows.begin(), rows.end(), IsUneven);
  stage.Count("uneven_photos", uint64_t(uneven));
  if (uneven > 0) LogWarning("{}", UnevenWarning(size_t(uneven), rows.size()));
}

void WriteCorrections(const Scene& scene, std::span<const RenderView> given,
                      std::span<const CorrectedPose> poses, std::span<const uint8_t> left_out,
                      Stage& stage) {
  if (poses.empty()) return;
  const std::vector<int> views = scene.ViewsOf(Split::kTrain);
  std::vector<CameraCorrection> rows;
  for (size_t i = 0; i < poses.size(); ++i) {
    if (!left_out.empty() && left_out[i]) continue;
    rows.push_back(CorrectionOf(scene.views[size_t(views[i])].name, given[i], poses[i]));
  }
  WriteCameraCorrections(stage.Output(kCameraCorrectionsFile), rows);
  const auto moved = std::count_if(rows.begin(), rows.end(), MovedMuch);
  stage.Count("moved_cameras", uint64_t(moved));
  if (moved > 0) LogWarning("{}", MovedMuchWarning(size_t(moved), rows.size()));
}

void WriteLeftOut(const Scene& scene, std::span<const uint8_t> left_out, Stage& stage) {
  const std::vector<int> views = scene.ViewsOf(Split::kTrain);
  std::vector<std::string> names;
  for (size_t i = 0; i < left_out.size(); ++i) {
    if (left_out[i]) names.push_back(scene.views[size_t(views[i])].name);
  }
  stage.Count("left_out_photos", names.size());
  if (names.empty()) return;
  WriteLeftOutPhotos(stage.Output(kLeftOutPhotosFile), names);
  LogWarning(
      "{} of {} photos do not fit the others and are left out: {}; their cameras or exposures may "
      "be "
      "wrong, or something in them has moved",
      names.size(), views.size(), ShortList(names));
}

void WriteWorld(const Scene& scene, const fs::path& scene_folder, Stage& stage) {
  FieldWorld world{scene.input_from_world, scene.subject_bounds, {}, {}};
  for (const View& view : scene.views) {
    world.cameras_in_world.push_back(view.cam_from_world.Inverse().translation);
  }
  world.scene = fs::relative(scene_folder, stage.folder()).generic_string();
  WriteFieldWorld(stage.Output(kFieldWorldFile), world);
}

}  // namespace tetrec
