// Structure from motion: from photos by COLMAP to undistorted views, cameras and sparse points.
#include "sfm/sfm.h"

#include "core/error.h"
#include "core/log.h"
#include "core/parallel.h"
#include "core/progress.h"
#include "core/timer.h"
#include "geometry/quarter_turns.h"
#include "geometry/undistorted_camera.h"
#include "image/color_profile.h"
#include "image/image.h"
#include "image/photo.h"
#include "image/undistort.h"
#include "scene/image_files.h"
#include "scene/split.h"
#include "scene/subject_bounds.h"
#include "sfm/map_photos.h"
#include "sfm/masks.h"
#include "sfm/model_quality.h"
#include "sfm/photos.h"
#include "sfm/thin_views.h"
#include "sfm/video.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <atomic>
#include <map>

namespace tetrec {
namespace fs = std::filesystem;
namespace {

constexpr const char* kLensAdvice = "try camera model SIMPLE_RADIAL or SIMPLE_PINHOLE, or auto";

std::map<std::string, const Photo*> ByName(const std::vector<Photo>& photos) {
  std::map<std::string, const Photo*> photo_of;
  for (const Photo& photo : photos) photo_of[photo.name] = &photo;
  return photo_of;
}

// The model's cameras describe the photos as they are stored, the scene's cameras describe upright
// images: photos of one camera that were stored on different sides get different scene cameras.
Scene SceneFromModel(const ColmapModel& model, const fs::path& folder,
                     const std::vector<Photo>& photos, const SfmOptions& options) {
  Scene scene;
  const std::map<std::string, const Photo*> photo_of = ByName(photos);
  std::map<std::pair<uint32_t, int>, int> camera_index;
  std::vector<std::string> names;
  for (const auto& [id, image] : model.images) names.push_back(image.name);
  const std::vector<std::string> files = ImageFiles(names);
  for (const auto& [id, image] : model.images) {
    const int turns = photo_of.at(image.name)->quarter_turns;
    const auto [camera, is_new] =
        camera_index.try_emplace({image.camera, turns}, int(scene.cameras.size()));
    if (is_new) {
      const Lens& lens = model.cameras.at(image.camera);
      const auto add = [&] {
        scene.cameras.push_back(TurnedClockwise(UndistortedCamera(lens, options.max_size), turns));
      };
      NamingLens(folder / image.name, lens, add, kLensAdvice);
    }
    View view;
    view.name = image.name;
    view.image = files[scene.views.size()];
    view.camera = camera->second;
    view.cam_from_world = ClockwiseTurn(turns) * image.cam_from_world;
    scene.views.push_back(std::move(view));
  }
  HoldOut(scene.views, options.holdout);
  for (const auto& [id, point] : model.points) {
    scene.points.push_back(
        {point.position, point.color_srgb, float(point.error_px), uint32_t(point.track.size())});
  }
  return scene;
}

void LogTurned(const std::vector<Photo>& photos) {
  const auto turned = std::count_if(photos.begin(), photos.end(),
                                    [](const Photo& photo) { return photo.quarter_turns != 0; });
  if (turned == 0) return;
  LogInfo(
      "photos that are stored on their side or upside down: {} of {}; they are turned upright by "
      "their EXIF",
      turned, photos.size());
}

Image WithoutAlpha(const Image& rgba) {
  Image rgb{rgba.width, rgba.height, 3, {}};
  rgb.pixels.reserve(size_t(rgba.width) * rgba.height * 3);
  for (size_t i = 0; i < rgba.pixels.size(); ++i) {
    if (i % 4 != 3) rgb.pixels.push_back(rgba.pixels[i]);
  }
  return rgb;
}

void WriteViews(const Scene& scene, const ColmapModel& model, const fs::path& photos_folder,
                const std::vector<Photo>& photos, const fs::path& folder) {
  const std::map<std::string, const Photo*> photo_of = ByName(photos);
  std::map<std::string, const Lens*> camera_of;
  for (const auto& [id, image] : model.images)
    camera_of[image.name] = &model.cameras.at(image.camera);
  for (const View& view : scene.views) fs::create_directories((folder / view.image).parent_path());
  std::atomic<size_t> with_alpha = 0;
  std::vector<ProfileUse> profiles(scene.views.size());
  const auto write = [&](size_t i) {
    const View& view = scene.views[i];
    const Photo& photo = *photo_of.at(view.name);
    Image image = ReadPicture(photo.file, profiles[i]);
    if (image.channels == 4) {
      image = WithoutAlpha(image);
      ++with_alpha;
    }
    if (scene.has_masks) image = MaskedPhoto(image, photo);
    const Lens& lens = *camera_of.at(view.name);
    const Camera as_stored =
        TurnedClockwise(scene.cameras[size_t(view.camera)], 4 - photo.quarter_turns);
    NamingLens(
        photos_folder / view.name, lens, [&] { image = Undistort(image, lens, as_stored); },
        kLensAdvice);
    WriteImage(folder / view.image, TurnedClockwise(image, photo.quarter_turns));
  };
  ParallelForEach(scene.views.size(), "undistorting: photo", "COLMAP's results are kept", write);
  std::vector<std::string> names;
  for (const View& view : scene.views) names.push_back(view.name);
  LogProfileUses(names, profiles);
  if (with_alpha > 0) {
    LogWarning(
        "{} photos have transparency, which is not used: it was dropped, the colours beneath were "
        "kept",
        with_alpha.load());
  }
}

// The world becomes that of the subject, or of the box that the user gives for it.
void MoveToBounds(const SfmOptions& options, const Subject& subject, Scene& scene, Stage& stage) {
  MoveToSubject(scene, subject);
  if (options.bounds_in_found_world) {
    MoveToBox(scene, *options.bounds_in_found_world);
    const auto contained = std::count_if(
        scene.points.begin(), scene.points.end(),
        [&](const ScenePoint& point) { return scene.subject_bounds.Contains(point.position); });
    if (contained == 0) {
      throw DataError(
          "the given bounds contain none of the points; they are coordinates of the points.ply "
          "that is written without bounds");
    }
    LogInfo("given bounds: {} of {} points are inside", WithThousands(size_t(contained)),
            WithThousands(scene.points.size()));
    return;
  }
  if (subject.outside > 0) {
    LogInfo(
        "{} of the subject's points are outside of its bounds, as outliers; others can be given",
        WithThousands(subject.outside));
  }
  stage.Count("subject_points_outside", subject.outside);
}

void Report(const ModelQuality& quality, const Scene& scene,
            const std::vector<std::string>& unregistered, const Subject& subject,
            bool bounds_are_given, Stage& stage) {
  LogInfo(
      "{} of {} photos registered, {} points, mean reprojection error {:.3f} px, mean track "
      "length {:.2f}",
      quality.registered, quality.photos, WithThousands(quality.points), quality.mean_error_px,
      quality.mean_track_length);
  if (!unregistered.empty()) {
    LogWarning("{} photos are not registered and left out: {}", unregistered.size(),
               fmt::join(unregistered, ", "));
  }
  const glm::dvec3 size = scene.subject_bounds.Size();
  LogInfo(
      "subject: {:.2f} x {:.2f} x {:.2f} units, {}; {} views to train on, {} held out", size.x,
      size.y, size.z,
      bounds_are_given ? "as given" : fmt::format("from {} points", WithThousands(subject.points)),
      scene.ViewsOf(Split::kTrain).size(), scene.ViewsOf(Split::kTest).size());
  stage.Count("photos", quality.photos);
  stage.Count("registered", quality.registered);
  stage.Count("points", quality.points);
  if (!bounds_are_given) stage.Count("subject_points", subject.points);
  stage.Count("train_views", scene.ViewsOf(Split::kTrain).size());
  stage.Count("test_views", scene.ViewsOf(Split::kTest).size());
  stage.Count("mean_reprojection_error_px", quality.mean_error_px);
  stage.Count("mean_track_length", quality.mean_track_length);
  stage.Note("unregistered", unregistered);
  stage.Note("resolution", {scene.cameras.front().width, scene.cameras.front().height});
}

// The folder of photos that was given, or one with frames of the video that was given.
fs::path PhotosFolder(const SfmOptions& options, Stage& stage) {
  const fs::path input = stage.Input("PHOTOS");
  if (!fs::is_regular_file(input)) return input;
  const fs::path scratch = stage.Scratch("video");
  WriteVideoFrames(input, size_t(options.frames), scratch / "frames", scratch);
  return scratch / "frames";
}

}  // namespace

void RunSfm(const SfmOptions& options, Stage& stage) {
  options.Check();
  Timer timer;
  const fs::path folder = PhotosFolder(options, stage);
  const fs::path masks = stage.HasInput("masks") ? stage.Input("masks") : fs::path();
  auto [photos, unreadable] =
      FindPhotos(folder, options.max_unreadable, stage.Cache("photos"), masks);
  stage.Count("unreadable", unreadable.size());
  stage.Note("unreadable", unreadable);
  if (!masks.empty()) stage.Note("hidden_by_masks", AddMasks(masks, photos));
  stage.Seconds("check", timer.seconds());
  const ColmapModel model = MapPhotos(options, photos, stage);
  std::vector<std::string> names;
  for (const Photo& photo : photos) names.push_back(photo.name);
  const ModelQuality quality = JudgeModel(model, names);

  timer = {};
  Scene scene = SceneFromModel(model, folder, photos, options);
  scene.has_masks = !photos.front().mask.empty();
  if (options.train_every > 1) {
    const size_t dropped = ThinTrainingViews(model, options.train_every, scene);
    LogInfo("{} views are neither trained on nor held out and left out; {} points are left",
            dropped, WithThousands(scene.points.size()));
    stage.Count("dropped_views", dropped);
  }
  LogTurned(photos);
  const Subject subject = FindSubject(scene);
  MoveToBounds(options, subject, scene, stage);
  stage.Output("images");
  WriteViews(scene, model, folder, photos, stage.folder());
  WriteScene(stage.folder(), scene);
  stage.Output("scene.json");
  stage.Output("points.ply");
  stage.Seconds("undistort", timer.seconds());
  Report(quality, scene, UnregisteredPhotos(model, names), subject,
         options.bounds_in_found_world.has_value(), stage);
}

}  // namespace tetrec
