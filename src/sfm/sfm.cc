// Structure from motion: from photos by COLMAP to undistorted views, cameras and sparse points.
#include "sfm/sfm.h"

#include "colmap/database.h"
#include "colmap/run.h"
#include "core/error.h"
#include "core/file.h"
#include "core/log.h"
#include "core/parallel.h"
#include "core/progress.h"
#include "core/timer.h"
#include "geometry/undistorted_camera.h"
#include "image/image.h"
#include "image/photo.h"
#include "image/undistort.h"
#include "scene/image_files.h"
#include "scene/split.h"
#include "scene/subject_bounds.h"
#include "sfm/masks.h"
#include "sfm/model_quality.h"
#include "sfm/photos.h"
#include "sfm/retry.h"
#include "sfm/thin_views.h"
#include "sfm/video.h"
#include "sfm/work_key.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <atomic>
#include <map>
#include <set>

namespace tetrec {
namespace fs = std::filesystem;
namespace {

// Photos per camera; fewer do not determine the four OPENCV distortion parameters well.
constexpr size_t kPhotosForOpenCvModel = 8;
constexpr int kMostFeatures = 100000;  // as SfmOptions::Check allows
constexpr const char* kLensAdvice = "try camera model SIMPLE_RADIAL or PINHOLE";

// COLMAP's view of the photos: links with plain names, in one folder per camera. The user's names
// may contain spaces, which COLMAP's lists cannot.
struct LinkedPhotos {
  fs::path folder;
  fs::path masks;                  // NAME.png for each name; empty if there are none
  std::vector<std::string> names;  // in the order of the photos
  std::map<std::string, size_t> photo_of_name;
  size_t cameras = 0;
};

std::string CameraGroup(const Photo& photo, CameraSharing sharing) {
  const std::string size = fmt::format("{}x{}", photo.width, photo.height);
  if (sharing == CameraSharing::kPerFolder)
    return size + fs::path(photo.name).parent_path().string();
  if (sharing == CameraSharing::kPerImage) return photo.name;
  return size;
}

LinkedPhotos LinkPhotos(const std::vector<Photo>& photos, CameraSharing sharing,
                        const fs::path& folder) {
  LinkedPhotos linked{folder, {}, {}, {}, 0};
  fs::remove_all(folder);
  std::map<std::string, size_t> groups;
  for (const Photo& photo : photos) groups.emplace(CameraGroup(photo, sharing), groups.size());
  if (sharing == CameraSharing::kSingle && groups.size() > 1) {
    throw DataError(
        fmt::format("the photos have {} different sizes, which one camera cannot have; use camera "
                    "sharing {}",
                    groups.size(), Name(CameraSharing::kAuto)));
  }
  const size_t digits = std::to_string(photos.size()).size();
  for (size_t i = 0; i < photos.size(); ++i) {
    const std::string group = sharing == CameraSharing::kPerImage
                                  ? "0"
                                  : std::to_string(groups.at(CameraGroup(photos[i], sharing)));
    const std::string extension = photos[i].for_colmap.extension().string();
    const std::string name = fmt::format("{}/{:0{}}{}", group, i, digits, extension);
    fs::create_directories(folder / group);
    fs::create_symlink(fs::absolute(photos[i].for_colmap), folder / name);
    linked.names.push_back(name);
    linked.photo_of_name[name] = i;
  }
  linked.cameras = groups.size();
  return linked;
}

// Writes the masks under the names of the photos' links.
void WriteColmapMasks(const std::vector<Photo>& photos, const fs::path& folder,
                      LinkedPhotos& linked) {
  if (photos.front().mask.empty()) return;
  fs::remove_all(folder);
  for (const std::string& name : linked.names) {
    fs::create_directories((folder / name).parent_path());
  }
  ParallelForEach(photos.size(), "", "nothing was done yet", [&](size_t i) {
    WriteColmapMask(folder / (linked.names[i] + ".png"), photos[i]);
  });
  linked.masks = folder;
}

SfmLens LensFor(const SfmOptions& options, size_t photos, size_t cameras) {
  if (options.camera_model != SfmLens::kAuto) return options.camera_model;
  return photos >= kPhotosForOpenCvModel * cameras ? SfmLens::kOpenCv : SfmLens::kSimpleRadial;
}

std::string FeaturesKey(const std::vector<Photo>& photos, const LinkedPhotos& linked,
                        const ExtractOptions& extract, const std::string& colmap_version) {
  nlohmann::json key = {{"colmap", colmap_version},
                        {"model", extract.camera_model},
                        {"per_image", extract.camera_per_image},
                        {"features", extract.max_features},
                        {"format", 2}};  // 1: COLMAP's own number of features
  for (size_t i = 0; i < photos.size(); ++i)
    key["photos"].push_back({linked.names[i], photos[i].sha256});
  if (!linked.masks.empty()) {
    for (const Photo& photo : photos) key["masks"].push_back(photo.mask_sha256);
  }
  return WorkKey(key);
}

void CopyDatabase(const fs::path& from, const fs::path& to) {
  const fs::path half = to.string() + ".tmp";
  std::error_code error;
  fs::copy_file(from, half, fs::copy_options::overwrite_existing, error);
  if (error)
    throw EnvironmentError(
        fmt::format("{}: cannot be written ({})", half.string(), error.message()));
  fs::rename(half, to);
}

fs::path ModelWithMostImages(const std::vector<fs::path>& folders, ColmapModel& best) {
  fs::path chosen;
  for (const fs::path& folder : folders) {
    ColmapModel model = ReadColmapModel(folder);
    LogInfo("model {}: {} photos, {} points", folder.filename().string(), model.images.size(),
            model.points.size());
    const auto rank = [](const ColmapModel& m) {
      return std::pair(m.images.size(), m.points.size());
    };
    if (chosen.empty() || rank(model) > rank(best)) {
      chosen = folder;
      best = std::move(model);
    }
  }
  return chosen;
}

// Gives the model's images the photos' own names.
void Rename(ColmapModel& model, const LinkedPhotos& linked, const std::vector<Photo>& photos) {
  for (auto& [id, image] : model.images) {
    const auto found = linked.photo_of_name.find(image.name);
    if (found == linked.photo_of_name.end()) {
      throw DataError(fmt::format("COLMAP's model contains the image {}, which is not one of ours",
                                  image.name));
    }
    image.name = photos[found->second].name;
  }
}

// The model with the most images of a database, from the cache if it is there; without images if
// COLMAP found none.
struct Mapping {
  ColmapModel model;
  size_t models = 0;  // found now; 0: from the cache, or none
};

Mapping Map(const ColmapProgram& colmap, const fs::path& photos, const fs::path& database,
            size_t photo_count, int seed, const MapperDemands& demands, const fs::path& scratch,
            const fs::path& finished) {
  Mapping mapping;
  if (!fs::exists(finished)) {
    const fs::path models = scratch / "models";
    fs::remove_all(models);
    fs::create_directories(models);
    const std::vector<fs::path> folders =
        MapScene(colmap, photos, database, photo_count, seed, demands, models);
    if (folders.empty()) return mapping;
    mapping.models = folders.size();
    fs::rename(ModelWithMostImages(folders, mapping.model), finished);
  }
  mapping.model = ReadColmapModel(finished);
  return mapping;
}

// What all tries of one run share.
struct SfmWork {
  const SfmOptions& options;
  const ColmapProgram& colmap;
  const LinkedPhotos& linked;
  const ExtractOptions& extract;
  fs::path scratch, cache;
};

// The ids of the photos in the database that the model lacks.
std::set<uint32_t> MissingPhotos(const std::vector<DatabaseImage>& images,
                                 const ColmapModel& model) {
  std::set<std::string> registered;
  for (const auto& [id, image] : model.images) registered.insert(image.name);
  std::set<uint32_t> missing;
  for (const DatabaseImage& image : images) {
    if (!registered.contains(image.name)) missing.insert(image.id);
  }
  return missing;
}

// Makes a database with more features of the photos that the missing ones concern, and matches
// them.
void WriteRicherDatabase(const SfmWork& work, const ColmapModel& model, int max_features,
                         const fs::path& before, const fs::path& richer) {
  std::vector<std::string> names;
  std::vector<ImagePair> pairs;
  {
    const ColmapDatabase database(before, work.colmap.version);
    const std::vector<DatabaseImage> images = database.Images();
    const std::set<uint32_t> missing = MissingPhotos(images, model);
    std::vector<uint32_t> ids;
    for (const DatabaseImage& image : images) ids.push_back(image.id);
    const std::vector<uint32_t> concerned = ConcernedPhotos(ids, missing, database.MatchCounts());
    pairs = PairsOfRetry(ids, concerned, missing);
    for (const DatabaseImage& image : images) {
      if (std::binary_search(concerned.begin(), concerned.end(), image.id)) {
        names.push_back(image.name);
      }
    }
    LogInfo(
        "{} photos are not registered; trying again with up to {} features of {} photos, in {} "
        "pairs",
        missing.size(), WithThousands(size_t(max_features)), names.size(), pairs.size());
  }
  const fs::path features = richer.string() + ".features", parts = richer.string() + ".parts";
  ExtractOptions extract = work.extract;
  extract.max_features = max_features;
  if (!fs::exists(features)) {
    ExtractFeatures(work.colmap, work.linked.folder, names, extract, parts, features);
    fs::remove_all(parts);
  }
  if (!fs::exists(richer)) {
    const fs::path half = richer.string() + ".half";
    CopyDatabase(before, half);
    {
      ColmapDatabase database(half, work.colmap.version);
      const uint64_t added = database.AppendFiner(ColmapDatabase(features, work.colmap.version));
      LogInfo("{} features more", WithThousands(added));
      database.ForgetPairs(pairs);
    }
    fs::rename(half, richer);
  }
  MatchFeatures(work.colmap, richer, pairs, work.scratch);
}

// Maps once more, and keeps the better model. `how`: notes what differs in this try, which began
// with `timer`.
void MapAgain(const SfmWork& work, const fs::path& database, const MapperDemands& demands,
              const fs::path& finished, nlohmann::json how, const Timer& timer, ColmapModel& model,
              nlohmann::json& notes) {
  const Mapping mapping = Map(work.colmap, work.linked.folder, database, work.linked.names.size(),
                              work.options.seed, demands, work.scratch, finished);
  const bool better = IsBetterModel(model, mapping.model);
  LogInfo(
      "{} photos registered instead of {}, mean reprojection error {:.3f} px instead of "
      "{:.3f}: {}",
      mapping.model.images.size(), model.images.size(), MeanReprojectionError_px(mapping.model),
      MeanReprojectionError_px(model), better ? "kept" : "not kept");
  how.update({{"registered_before", model.images.size()},
              {"registered", mapping.model.images.size()},
              {"mean_reprojection_error_px", MeanReprojectionError_px(mapping.model)},
              {"kept", better},
              {"seconds", timer.seconds()}});
  notes.push_back(std::move(how));
  if (better) model = mapping.model;
}

// Tries again where photos stayed out: with more features of them; and at last, if the model would
// be refused, with milder demands of the mapper. Where only some photos stay out, those may well
// show something else. Each try is noted.
void Retry(const SfmWork& work, const fs::path& database, const std::string& model_name,
           ColmapModel& model, Stage& stage) {
  nlohmann::json notes = nlohmann::json::array();
  int max_features = work.options.max_features;
  fs::path richest = database;
  std::string suffix;
  const size_t photos = work.linked.names.size();
  for (int i = 1; i <= work.options.retries && model.images.size() < photos; ++i) {
    const Timer timer;
    max_features = std::min(max_features * 8 / 3, kMostFeatures);
    suffix = fmt::format("-retry-{}", i);
    const fs::path richer = database.string() + suffix;
    WriteRicherDatabase(work, model, max_features, richest, richer);
    MapAgain(work, richer, kUsualDemands, work.cache / (model_name + suffix),
             {{"max_features", max_features}}, timer, model, notes);
    richest = richer;
  }
  if (!HasEnoughPhotos(model, photos)) {
    LogInfo(
        "{} of {} photos are registered; trying again with at least {} instead of {} inliers "
        "for the first pair, and {} instead of {} for each further photo",
        model.images.size(), photos, kMildDemands.pair_inliers, kUsualDemands.pair_inliers,
        kMildDemands.image_inliers, kUsualDemands.image_inliers);
    MapAgain(work, richest, kMildDemands, work.cache / (model_name + suffix + "-mild"),
             {{"pair_inliers", kMildDemands.pair_inliers},
              {"image_inliers", kMildDemands.image_inliers}},
             Timer(), model, notes);
  }
  stage.Count("retries", notes.size());
  stage.Note("retries", notes);
}

// Features, matches and model by this lens, from the cache as far as it has them.
ColmapModel MapByLens(SfmLens lens, const SfmOptions& options, const std::vector<Photo>& photos,
                      const LinkedPhotos& linked, const ColmapProgram& colmap, Stage& stage) {
  const fs::path scratch = stage.Scratch("work");
  const ExtractOptions extract{Name(lens), options.camera_sharing == CameraSharing::kPerImage,
                               options.max_features, linked.masks};
  const fs::path cache =
      stage.Cache("colmap") / FeaturesKey(photos, linked, extract, colmap.version);
  fs::create_directories(cache);
  const fs::path features = cache / "features.db",
                 database = cache / fmt::format("{}.db", Name(options.matcher));

  Timer timer;
  if (!fs::exists(features)) {
    ExtractFeatures(colmap, linked.folder, linked.names, extract, cache / "parts", features);
    fs::remove_all(cache / "parts");
  }
  if (!fs::exists(database)) CopyDatabase(features, database);
  stage.Seconds("features", timer.seconds());

  timer = {};
  const MatchCounts matches = MatchFeatures(colmap, database, options.matcher, scratch);
  LogInfo("{} matches in {} pairs", WithThousands(matches.matches), WithThousands(matches.pairs));
  stage.Count("pairs", matches.pairs);
  stage.Count("matches", matches.matches);
  stage.Seconds("matching", timer.seconds());

  timer = {};
  const std::string model_name = fmt::format("mapped-{}-{}", Name(options.matcher), options.seed);
  Mapping mapping = Map(colmap, linked.folder, database, photos.size(), options.seed, kUsualDemands,
                        scratch, cache / model_name);
  if (mapping.models > 0) stage.Count("models", mapping.models);
  stage.Seconds("mapping", timer.seconds());
  ColmapModel& model = mapping.model;
  if (options.retries > 0 && model.images.size() < photos.size()) {
    timer = {};
    Retry({options, colmap, linked, extract, scratch, cache}, database, model_name, model, stage);
    stage.Seconds("retries", timer.seconds());
  }
  if (model.images.empty()) {
    throw DataError(fmt::format(
        "COLMAP found no model: the {} photos do not overlap enough, or were taken from "
        "almost one place; take photos of one scene from many places, each sharing most "
        "of what it shows with the next",
        photos.size()));
  }
  Rename(model, linked, photos);
  return model;
}

// Whether a lens of the model cannot be undone inside the photos. Where features show the middle of
// the photos only, as those of a subject before a plain wall, nothing determines what a lens of
// many parameters does at their borders.
bool HasFoldedLens(const ColmapModel& model, int max_size) {
  try {
    for (const auto& [id, camera] : model.cameras) UndistortedCamera(camera, max_size);
  } catch (const DataError&) {
    return true;
  }
  return false;
}

// By the lens that was asked for, or by a simpler one than the usual if that one folds over.
ColmapModel RunColmap(const SfmOptions& options, const std::vector<Photo>& photos, Stage& stage) {
  const ColmapProgram colmap = FindColmap(stage.folder() / "log.txt");
  LogInfo("COLMAP {}: {} photos", colmap.version, photos.size());
  stage.Note("colmap", colmap.version);
  const fs::path scratch = stage.Scratch("work");
  LinkedPhotos linked = LinkPhotos(photos, options.camera_sharing, scratch / "photos");
  WriteColmapMasks(photos, scratch / "masks", linked);
  SfmLens lens = LensFor(options, photos.size(), linked.cameras);
  ColmapModel model = MapByLens(lens, options, photos, linked, colmap, stage);
  while (options.camera_model == SfmLens::kAuto && lens != SfmLens::kPinhole &&
         HasFoldedLens(model, options.max_size)) {
    const SfmLens simpler = lens == SfmLens::kOpenCv ? SfmLens::kSimpleRadial : SfmLens::kPinhole;
    LogInfo(
        "the lens that was found ({}) folds over inside the photos, because few features are "
        "near their borders; trying again with {}",
        Name(lens), Name(simpler));
    lens = simpler;
    model = MapByLens(lens, options, photos, linked, colmap, stage);
  }
  stage.Note("lens", Name(lens));
  return model;
}

// A photo that the camera took; the folder of the photos if it took none.
fs::path PhotoOfCamera(const ColmapModel& model, uint32_t camera, const fs::path& photos) {
  for (const auto& [id, image] : model.images) {
    if (image.camera == camera) return photos / image.name;
  }
  return photos;
}

Scene SceneFromModel(const ColmapModel& model, const fs::path& photos, const SfmOptions& options) {
  Scene scene;
  std::map<uint32_t, int> camera_index;
  for (const auto& [id, camera] : model.cameras) {
    camera_index[id] = int(scene.cameras.size());
    const Lens& lens = camera;
    NamingLens(
        PhotoOfCamera(model, id, photos), lens,
        [&] { scene.cameras.push_back(UndistortedCamera(lens, options.max_size)); }, kLensAdvice);
  }
  std::vector<std::string> names;
  for (const auto& [id, image] : model.images) names.push_back(image.name);
  const std::vector<std::string> files = ImageFiles(names);
  for (const auto& [id, image] : model.images) {
    View view;
    view.name = image.name;
    view.image = files[scene.views.size()];
    view.camera = camera_index.at(image.camera);
    view.cam_from_world = image.cam_from_world;
    scene.views.push_back(std::move(view));
  }
  HoldOut(scene.views, options.holdout);
  for (const auto& [id, point] : model.points) {
    scene.points.push_back(
        {point.position, point.color_srgb, float(point.error_px), uint32_t(point.track.size())});
  }
  return scene;
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
  std::map<std::string, const Photo*> photo_of;
  for (const Photo& photo : photos) photo_of[photo.name] = &photo;
  std::map<std::string, const Lens*> camera_of;
  for (const auto& [id, image] : model.images)
    camera_of[image.name] = &model.cameras.at(image.camera);
  for (const View& view : scene.views) fs::create_directories((folder / view.image).parent_path());
  std::atomic<size_t> with_alpha = 0;
  const auto write = [&](size_t i) {
    const View& view = scene.views[i];
    const Photo& photo = *photo_of.at(view.name);
    Image image = ReadPhoto(photo.file);
    if (image.channels == 4) {
      image = WithoutAlpha(image);
      ++with_alpha;
    }
    if (scene.has_masks) image = MaskedPhoto(image, photo);
    const Lens& lens = *camera_of.at(view.name);
    NamingLens(
        photos_folder / view.name, lens,
        [&] { image = Undistort(image, lens, scene.cameras[size_t(view.camera)]); }, kLensAdvice);
    WriteImage(folder / view.image, image);
  };
  ParallelForEach(scene.views.size(), "undistorting: photo", "COLMAP's results are kept", write);
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
  const ColmapModel model = RunColmap(options, photos, stage);
  std::vector<std::string> names;
  for (const Photo& photo : photos) names.push_back(photo.name);
  const ModelQuality quality = JudgeModel(model, names);

  timer = {};
  Scene scene = SceneFromModel(model, folder, options);
  scene.has_masks = !photos.front().mask.empty();
  if (options.train_every > 1) {
    const size_t dropped = ThinTrainingViews(model, options.train_every, scene);
    LogInfo("{} views are neither trained on nor held out and left out; {} points are left",
            dropped, WithThousands(scene.points.size()));
    stage.Count("dropped_views", dropped);
  }
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
