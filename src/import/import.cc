// Imports data sets with known cameras.
#include "import/import.h"

#include "core/error.h"
#include "core/log.h"
#include "core/quantile.h"
#include "core/short_list.h"
#include "core/timer.h"
#include "geometry/rotation.h"
#include "image/color_profile.h"
#include "import/choose_split.h"
#include "import/stored_pictures.h"
#include "scene/carve.h"
#include "scene/points.h"
#include "scene/split.h"
#include "scene/subject_bounds.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

namespace tetrec {
namespace {

using internal::StoredPicture;

int IndexOfCamera(std::vector<Camera>& cameras, const Camera& camera) {
  const auto same = [&](const Camera& other) {
    return other.width == camera.width && other.height == camera.height && other.fx == camera.fx &&
           other.fy == camera.fy && other.cx == camera.cx && other.cy == camera.cy;
  };
  const auto found = std::find_if(cameras.begin(), cameras.end(), same);
  if (found != cameras.end()) return int(found - cameras.begin());
  cameras.push_back(camera);
  return int(cameras.size()) - 1;
}

// The track length of points that came without tracks becomes the number of training views whose
// image contains them, an upper bound of those that see them.
void CountTracks(Scene& scene) {
  const std::vector<int> training = scene.ViewsOf(Split::kTrain);
  for (ScenePoint& point : scene.points) {
    if (point.track_length > 0) continue;
    for (const int i : training) {
      const View& view = scene.views[size_t(i)];
      const Camera& camera = scene.cameras[size_t(view.camera)];
      point.track_length += camera.Shows(view.cam_from_world * point.position) ? 1 : 0;
    }
  }
}

// Points in the right frame are within the images that they came from.
void CheckSeen(const std::vector<ScenePoint>& points) {
  const auto unseen = size_t(std::count_if(
      points.begin(), points.end(), [](const ScenePoint& p) { return p.track_length == 0; }));
  if (2 * unseen <= points.size()) return;
  throw DataError(fmt::format(
      "{} of {} points are within no training image: points and cameras have different frames; "
      "give the points of these cameras, or triangulate points, which replace them",
      unseen, points.size()));
}

// The data set as a scene, still in the input's frame.
Scene SceneInInput(const Dataset& set, const std::vector<StoredPicture>& stored) {
  Scene scene;
  scene.has_alpha = stored[0].has_alpha;
  scene.has_masks = stored[0].has_mask;
  scene.points = set.points;
  for (size_t i = 0; i < set.pictures.size(); ++i) {
    const PosedPicture& picture = set.pictures[i];
    View view;
    view.name = picture.name;
    view.image = picture.image;
    view.camera = IndexOfCamera(scene.cameras, stored[i].camera);
    view.cam_from_world = picture.cam_from_input;
    view.split = picture.split;
    scene.views.push_back(std::move(view));
  }
  CountTracks(scene);
  CheckSeen(scene.points);
  return scene;
}

std::string Text(const glm::dvec3& v) {
  return fmt::format("({:.3f}, {:.3f}, {:.3f})", v.x, v.y, v.z);
}

// The data set's own box, if it bounds the subject: around the cameras it contains more, and where
// they do not look it contains something else.
std::optional<Bounds3> OwnBox(const Dataset& set, const std::vector<AlphaMask>& training) {
  if (!set.box_in_input) return std::nullopt;
  const Bounds3& box = *set.box_in_input;
  const auto count = [&](const auto& condition) {
    return size_t(std::count_if(training.begin(), training.end(), condition));
  };
  if (count([&](const AlphaMask& view) {
        return box.Contains(view.cam_from_world.Inverse().translation);
      }) > 0) {
    LogInfo("the data set's box, {} to {}, contains cameras and so more than the subject",
            Text(box.min), Text(box.max));
    return std::nullopt;
  }
  const size_t seeing = count(
      [&](const AlphaMask& view) { return view.camera.Shows(view.cam_from_world * box.Center()); });
  if (2 * seeing >= training.size()) return box;
  LogWarning(
      "the data set's box, {} to {}, is not used, because only {} of {} training images show its "
      "centre",
      Text(box.min), Text(box.max), seeing, training.size());
  return std::nullopt;
}

// The subject's bounds without the help of points.
Bounds3 SubjectBoundsInInput(const Dataset& set, std::vector<StoredPicture>& stored) {
  std::vector<AlphaMask> masks;
  for (size_t i = 0; i < set.pictures.size(); ++i) {
    if (set.pictures[i].split != Split::kTrain) continue;
    masks.push_back({stored[i].camera, set.pictures[i].cam_from_input, std::move(stored[i].alpha)});
  }
  if (stored[0].has_alpha) return FindSubjectBounds(masks);
  if (const std::optional<Bounds3> box = OwnBox(set, masks)) return *box;
  if (const std::optional<Bounds3> seen = BoxSeenByAll(masks)) {
    LogWarning(
        "the images have neither alpha nor points: the subject's bounds are what all training "
        "cameras see");
    return *seen;
  }
  const Bounds3 around = BoxAroundCameras(masks);
  LogWarning(
      "the images have neither alpha nor points, and the training cameras do not look at one "
      "place: the subject's bounds are a box around the cameras; give better bounds, or "
      "triangulate "
      "points to find them");
  return around;
}

// The upright axes: z remains the input's if it is within 45 degrees of the cameras' up; otherwise
// it is the axis, or its opposite, that is nearest to it (COLMAP models often have y down). Turns
// by quarters keep a box a box.
glm::dmat3 InputFromUpright(std::span<const View> views_in_input) {
  const glm::dvec3 up = FindUp(views_in_input);
  if (up.z > std::sqrt(0.5)) return glm::dmat3(1.0);
  int nearest = 0;
  for (int axis = 1; axis < 3; ++axis) {
    if (std::abs(up[axis]) > std::abs(up[nearest])) nearest = axis;
  }
  glm::dvec3 x(0.0), z(0.0);
  x[nearest == 0 ? 1 : 0] = 1;
  z[nearest] = up[nearest] > 0 ? 1 : -1;
  return {x, glm::cross(z, x), z};
}

// To an upright world in which the bounds have centre 0 and longest side 2.
Similarity3 InputFromWorld(const Bounds3& bounds_in_input, std::span<const View> views_in_input) {
  const glm::dvec3 size = bounds_in_input.Size();
  return {0.5 * std::max({size.x, size.y, size.z}), InputFromUpright(views_in_input),
          bounds_in_input.Center()};
}

void MoveToBounds(Scene& scene, const Bounds3& bounds_in_input) {
  LogInfo("subject in the input's coordinates: {} to {}", Text(bounds_in_input.min),
          Text(bounds_in_input.max));
  scene.input_from_world = InputFromWorld(bounds_in_input, scene.views);
  const Similarity3 world_from_input = scene.input_from_world.Inverse();
  scene.subject_bounds = {};
  scene.subject_bounds.Add(world_from_input * bounds_in_input.min);
  scene.subject_bounds.Add(world_from_input * bounds_in_input.max);
  for (View& view : scene.views) {
    view.cam_from_world = CamFromWorld(view.cam_from_world, scene.input_from_world);
  }
  for (ScenePoint& point : scene.points) point.position = world_from_input * point.position;
}

// Cameras hardly took images of anything that is so far from all of them.
void WarnOfDistance(const glm::dvec3& place, const char* what, const Scene& scene) {
  constexpr double kFar = 30;
  Bounds3 cameras;
  double distance = INFINITY;
  for (const int i : scene.ViewsOf(Split::kTrain)) {
    const glm::dvec3 camera = scene.views[size_t(i)].cam_from_world.Inverse().translation;
    cameras.Add(camera);
    distance = std::min(distance, glm::distance(camera, place));
  }
  const double spread = cameras.Diagonal();
  if (!(distance > kFar * spread) || spread == 0) return;
  LogWarning(
      "{} at {} is {:.0f} times as far from the nearest camera as the cameras are apart; "
      "does it belong to their coordinates?",
      what, Text(place), distance / spread);
}

// Along each axis, half of the points are on either side of it.
glm::dvec3 MedianOf(const std::vector<ScenePoint>& points) {
  glm::dvec3 median;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const ScenePoint& point : points) values.push_back(point.position[axis]);
    median[axis] = Quantile(std::move(values), 0.5);
  }
  return median;
}

void MoveToSubjectOfPoints(Scene& scene) {
  WarnOfDistance(MedianOf(scene.points), "the middle of the points", scene);
  if (scene.points.size() < kFewPoints) {
    LogWarning("only {} points show where the subject is; its bounds would be more reliable",
               scene.points.size());
  }
  MoveToSubject(scene, FindSubject(scene));
  const Similarity3& input_from_world = scene.input_from_world;
  LogInfo("subject in the input's coordinates: around {}, {:.3f} long",
          Text(input_from_world * scene.subject_bounds.Center()),
          input_from_world.scale * 2);  // the longest side is 2 world units
}

ViewAlphas AlphasOf(const std::vector<StoredPicture>& stored) {
  ViewAlphas alphas;
  for (const StoredPicture& picture : stored) alphas.push_back(picture.alpha);
  return alphas;
}

// Drops the points of the data set that some training view sees through.
size_t DropTransparentPoints(const std::vector<StoredPicture>& stored, Scene& scene) {
  const ViewAlphas alphas = AlphasOf(stored);
  return std::erase_if(scene.points, [&](const ScenePoint& point) {
    return IsSeenThrough(scene, alphas, point.position);
  });
}

double MaskedShare(const std::vector<StoredPicture>& stored) {
  double masked = 0, pixels = 0;
  for (const StoredPicture& picture : stored) {
    masked += double(picture.masked_pixels);
    pixels += double(picture.camera.width) * picture.camera.height;
  }
  return masked / pixels;
}

Background BackgroundOf(const Scene& scene, const ImportOptions& options) {
  if (scene.has_alpha && options.background == Background::kScene) {
    throw DataError(
        "background is scene, but the images have alpha: expected white or black behind it");
  }
  return options.background.value_or(scene.has_alpha ? Background::kWhite : Background::kScene);
}

// Tells the user what may be wrong with the data set.
void LogFindings(const ImportedScene& imported) {
  for (const std::string& file : imported.missing_files) {
    LogWarning("{} is missing; the scene does without it", file);
  }
  if (!imported.skipped.empty()) {
    LogWarning("missing images, left out: {}: {}", imported.skipped.size(),
               ShortList(imported.skipped));
  }
  if (imported.turned > 0) {
    LogWarning("images rotated by their EXIF orientation, to match their cameras: {}",
               imported.turned);
  }
  if (imported.clipped_pixels > 0) {
    LogWarning("pixels too bright or too dark for display, clipped: {}", imported.clipped_pixels);
  }
  for (const std::string& remark : imported.remarks) LogWarning("{}", remark);
  if (imported.lenses_scaled > 0) {
    LogInfo("{} images differ in size from their cameras: the cameras were scaled to them",
            imported.lenses_scaled);
  }
  if (imported.cut_to_plane > 0) {
    LogWarning("{} images show more than 60 degrees to a side and were cropped there",
               imported.cut_to_plane);
  }
  if (imported.opaque > 0) {
    LogInfo("{} images have alpha or masks, none of which hides anything: dropped",
            imported.opaque);
  }
  if (imported.scene.has_masks) {
    LogInfo("masks exclude {:.1f} % of all pixels (masks subject: what they hide is empty)",
            100 * imported.masked_share);
  }
}

void LogScene(const ImportedScene& imported) {
  const Scene& scene = imported.scene;
  const Camera& camera = scene.cameras[0];
  LogInfo("{} training, {} validation, {} test views; {} x {} pixels; {} resized",
          scene.ViewsOf(Split::kTrain).size(), scene.ViewsOf(Split::kValidation).size(),
          scene.ViewsOf(Split::kTest).size(), camera.width, camera.height, imported.resized);
  if (imported.points_transparent > 0) {
    LogInfo("{} points that some training view sees through: dropped", imported.points_transparent);
  }
  if (imported.points_out_of_bounds > 0) {
    LogInfo("{} points outside the {} bounds: dropped", imported.points_out_of_bounds,
            scene.has_alpha ? "subject's" : "world's");
  }
}

void LogProfiles(const std::vector<PosedPicture>& pictures,
                 const std::vector<StoredPicture>& stored) {
  std::vector<std::string> names;
  std::vector<ProfileUse> uses;
  for (const PosedPicture& picture : pictures) names.push_back(picture.name);
  for (const StoredPicture& picture : stored) uses.push_back(picture.profile);
  LogProfileUses(names, uses);
}

// Counts and notes for the manifest.
void Record(const ImportedScene& imported, Stage& stage) {
  const Scene& scene = imported.scene;
  stage.Count("train_views", scene.ViewsOf(Split::kTrain).size());
  stage.Count("validation_views", scene.ViewsOf(Split::kValidation).size());
  stage.Count("test_views", scene.ViewsOf(Split::kTest).size());
  if (const auto& triangulation = imported.triangulation) {
    stage.Count("points_triangulated", triangulation->found);
    stage.Count("points_dropped_weak", triangulation->weak);
    stage.Count("points_dropped_transparent", triangulation->transparent);
  } else if (imported.points_transparent > 0) {
    stage.Count("points_dropped_transparent", imported.points_transparent);
  }
  stage.Count("points_dropped_out_of_bounds", imported.points_out_of_bounds);
  stage.Count("points", scene.points.size());
  stage.Count("cameras", scene.cameras.size());
  stage.Count("pictures_skipped", imported.skipped.size());
  stage.Count("pictures_resized", imported.resized);
  stage.Count("pictures_turned", imported.turned);
  stage.Count("pixels_clipped", imported.clipped_pixels);
  stage.Count("pictures_opaque", imported.opaque);
  stage.Count("lenses_scaled", imported.lenses_scaled);
  stage.Count("pictures_cut_to_plane", imported.cut_to_plane);
  stage.Note("missing_files", imported.missing_files);
}

}  // namespace

void ImportOptions::Check() const {
  if (max_size < 0 || max_size > 65536) {
    throw UsageError(
        fmt::format("max-size is {}; expected 0 (as stored) to 65536 pixels", max_size));
  }
  if (downscale && !(*downscale >= 1 && *downscale <= 1024)) {
    throw UsageError(fmt::format("downscale is {}; expected 1 to 1024", *downscale));
  }
  if (holdout) CheckHoldout(*holdout);
  if (bounds_in_input) CheckGivenBounds(*bounds_in_input);
}

Dataset ReadForImport(const std::filesystem::path& dataset, const ImportOptions& options) {
  options.Check();
  Dataset set = ReadDataset(
      dataset, options.format,
      {.images = options.images,
       .missing = options.skip_missing ? MissingPictures::kSkip : MissingPictures::kRefuse,
       .points = !options.triangulate});
  if (set.pictures.empty()) {
    throw DataError(fmt::format("{}: the data set has no images", dataset.string()));
  }
  internal::ChooseMasks(set.pictures, options.masks);
  internal::ChooseSplit(set, options);
  return set;
}

ImportedScene ImportDataset(const Dataset& set, const std::filesystem::path& folder,
                            const ImportOptions& options, const ColmapPlace& place) {
  std::vector<StoredPicture> stored = internal::StorePictures(set.pictures, folder, options);

  ImportedScene imported;
  imported.opaque = internal::DropIdleAlpha(set.pictures, folder, stored);
  internal::CheckAlike(set.pictures, stored);
  internal::CheckSomethingShows(set.pictures, stored);
  if (stored[0].has_mask) imported.masked_share = MaskedShare(stored);
  LogProfiles(set.pictures, stored);
  imported.missing_files = set.missing_files;
  imported.remarks = set.remarks;
  imported.skipped = set.skipped;
  for (const StoredPicture& picture : stored) {
    imported.resized += picture.resized;
    imported.turned += picture.turned;
    imported.lenses_scaled += picture.lens_scaled;
    imported.cut_to_plane += picture.cut_to_plane;
    imported.clipped_pixels += picture.clipped_pixels;
  }
  Scene& scene = imported.scene;
  scene = SceneInInput(set, stored);
  scene.background = BackgroundOf(scene, options);
  if (options.triangulate) {
    imported.triangulation = TriangulatePoints(folder, scene, AlphasOf(stored), place);
    scene.points = imported.triangulation->points;
  } else if (scene.has_alpha) {
    imported.points_transparent = DropTransparentPoints(stored, scene);
  }
  if (options.bounds_in_input) {
    WarnOfDistance(options.bounds_in_input->Center(), "the middle of the given bounds", scene);
    MoveToBounds(scene, *options.bounds_in_input);
  } else if (!scene.has_alpha && !scene.points.empty()) {
    MoveToSubjectOfPoints(scene);
  } else {
    MoveToBounds(scene, SubjectBoundsInInput(set, stored));
  }
  imported.points_out_of_bounds = std::erase_if(scene.points, [&](const ScenePoint& point) {
    const glm::dvec3 distance = glm::abs(point.position);
    if (std::max({distance.x, distance.y, distance.z}) > kFarthestPoint) return true;
    return scene.has_alpha && !scene.subject_bounds.Contains(point.position);
  });
  WriteScene(folder, scene);
  return imported;
}

ImportedScene ImportDataset(const std::filesystem::path& dataset,
                            const std::filesystem::path& folder, const ImportOptions& options,
                            const ColmapPlace& place) {
  return ImportDataset(ReadForImport(dataset, options), folder, options, place);
}

void RunImport(const ImportOptions& options, Stage& stage) {
  const Timer timer;
  ImportOptions with_list = options;
  if (stage.HasInput("test-list")) with_list.test_list = stage.Input("test-list");
  const Dataset set = ReadForImport(stage.Input("DATASET"), with_list);
  // An earlier scene stays until this one is complete.
  const std::filesystem::path imported_here = stage.Scratch("imported");
  std::filesystem::remove_all(imported_here);
  std::filesystem::create_directories(imported_here);
  const ColmapPlace place =
      options.triangulate
          ? ColmapPlace{stage.folder() / "log.txt", stage.Cache("colmap"), stage.Scratch("work")}
          : ColmapPlace{};
  const ImportedScene imported = ImportDataset(set, imported_here, with_list, place);
  for (const char* name : {"images", "points.ply", "scene.json"}) {
    if (!std::filesystem::exists(imported_here / name)) continue;
    const std::filesystem::path output = stage.Output(name);
    std::filesystem::remove_all(output);  // of an earlier run that was cut off here
    std::filesystem::rename(imported_here / name, output);
  }
  LogFindings(imported);
  LogScene(imported);
  Record(imported, stage);
  stage.Seconds("import", timer.seconds());
}

}  // namespace tetrec
