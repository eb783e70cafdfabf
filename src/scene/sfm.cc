// Structure from motion: photos -> COLMAP -> undistorted views, cameras, sparse points.
#include "scene/sfm.h"

#include "core/error.h"
#include "core/file.h"
#include "core/log.h"
#include "core/parallel.h"
#include "core/progress.h"
#include "core/short_list.h"
#include "scene/colmap_database.h"
#include "scene/colmap_run.h"
#include "scene/colmap_undistort.h"
#include "scene/dataset.h"
#include "scene/image.h"
#include "scene/sfm_bounds.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <set>

namespace tetrec {
namespace fs = std::filesystem;
namespace {

// What a model must reach to be built on, and what is worth a warning.
constexpr double kMinRegisteredShare = 0.8;
constexpr size_t kMinPoints = 100;
constexpr double kMaxError_px =
    1.5;  // for photos of up to kErrorSize_px; larger ones in proportion
constexpr double kErrorSize_px = 1600;
constexpr double kMinTrackLength = 2.5;
// With fewer pictures a camera the four OPENCV distortion parameters are not determined well.
constexpr size_t kPhotosForOpenCvModel = 8;
constexpr const char* kLensAdvice = "try --camera-model SIMPLE_RADIAL or PINHOLE";

const std::set<std::string> kMatchers = {"auto", "exhaustive", "sequential"};
const std::set<std::string> kSharings = {"auto", "single", "per-folder", "per-image"};
const std::set<std::string> kModels = {"auto",          "OPENCV",  "RADIAL",
                                       "SIMPLE_RADIAL", "PINHOLE", "SIMPLE_PINHOLE"};

void CheckOneOf(const std::string& value, const std::set<std::string>& known, const char* option) {
  if (!known.contains(value)) {
    throw UsageError(
        fmt::format("{} is \"{}\"; expected one of {}", option, value, fmt::join(known, ", ")));
  }
}

void CheckRange(int value, int min, int max, const char* option) {
  if (value < min || value > max) {
    throw UsageError(fmt::format("{} is {}; expected {} to {}", option, value, min, max));
  }
}

// Pictures by their names that are not read; phones write HEIC.
bool IsOtherPicture(const fs::path& path) {
  static const std::set<std::string> kExtensions = {
      ".heic", ".heif", ".avif", ".webp", ".tif", ".tiff", ".bmp", ".gif", ".jp2", ".jxl",
      ".exr",  ".dng",  ".cr2",  ".cr3",  ".nef", ".arw",  ".raf", ".orf", ".rw2"};
  std::string extension = path.extension().string();
  for (char& c : extension) c = char(std::tolower(static_cast<unsigned char>(c)));
  return kExtensions.contains(extension);
}

std::vector<std::string> PhotoNames(const fs::path& folder) {
  if (!fs::is_directory(folder)) {
    throw DataError(
        fmt::format("{}: is no folder; give the folder that holds the photos", folder.string()));
  }
  std::vector<std::string> names;
  std::vector<std::string> others, pictures;  // not read
  for (auto it = fs::recursive_directory_iterator(folder); it != fs::recursive_directory_iterator();
       ++it) {
    const bool hidden = it->path().filename().string().starts_with('.');
    if (hidden && it->is_directory()) it.disable_recursion_pending();
    if (hidden || !it->is_regular_file()) continue;
    if (HasPhotoExtension(it->path())) {
      names.push_back(it->path().lexically_relative(folder).generic_string());
    } else {
      const std::string name = it->path().lexically_relative(folder).generic_string();
      (IsOtherPicture(it->path()) ? pictures : others).push_back(name);
    }
  }
  if (!others.empty()) {
    LogInfo("{}: files that are no photos, passed over: {}: {}", folder.string(), others.size(),
            ShortList(others));
  }
  if (!pictures.empty()) {
    LogWarning("{}: pictures of other kinds than JPEG and PNG, left out: {}: {}; convert them",
               folder.string(), pictures.size(), ShortList(pictures));
  }
  std::sort(names.begin(), names.end());
  return names;
}

// COLMAP's view of the photos: links under plain names in a folder a camera. The user's names may
// hold spaces and line breaks, which COLMAP's lists cannot.
struct LinkedPhotos {
  fs::path folder;
  std::vector<std::string> names;  // as the photos are ordered
  std::map<std::string, size_t> photo_of_name;
  size_t cameras = 0;
};

std::string CameraGroup(const Photo& photo, const std::string& sharing) {
  const std::string size = fmt::format("{}x{}", photo.width, photo.height);
  if (sharing == "per-folder") return size + fs::path(photo.name).parent_path().string();
  if (sharing == "per-image") return photo.name;
  return size;
}

LinkedPhotos LinkPhotos(const fs::path& photos_folder, const std::vector<Photo>& photos,
                        const std::string& sharing, const fs::path& folder) {
  LinkedPhotos linked{folder, {}, {}, 0};
  fs::remove_all(folder);
  std::map<std::string, size_t> groups;
  for (const Photo& photo : photos) groups.emplace(CameraGroup(photo, sharing), groups.size());
  if (sharing == "single" && groups.size() > 1) {
    throw DataError(
        fmt::format("the photos have {} different sizes, which one camera cannot have; leave "
                    "--camera-sharing at auto",
                    groups.size()));
  }
  const size_t digits = std::to_string(photos.size()).size();
  for (size_t i = 0; i < photos.size(); ++i) {
    const std::string group =
        sharing == "per-image" ? "0" : std::to_string(groups.at(CameraGroup(photos[i], sharing)));
    std::string extension = fs::path(photos[i].name).extension().string();
    const std::string name = fmt::format("{}/{:0{}}{}", group, i, digits, extension);
    fs::create_directories(folder / group);
    fs::create_symlink(fs::absolute(photos_folder / photos[i].name), folder / name);
    linked.names.push_back(name);
    linked.photo_of_name[name] = i;
  }
  linked.cameras = groups.size();
  return linked;
}

std::string CameraModelFor(const SfmOptions& options, size_t photos, size_t cameras) {
  if (options.camera_model != "auto") return options.camera_model;
  return photos >= kPhotosForOpenCvModel * cameras ? "OPENCV" : "SIMPLE_RADIAL";
}

// A short name of all that decides the features.
std::string FeaturesKey(const std::vector<Photo>& photos, const LinkedPhotos& linked,
                        const ExtractOptions& extract, const std::string& colmap_version) {
  nlohmann::json key = {{"colmap", colmap_version},
                        {"model", extract.camera_model},
                        {"per_image", extract.camera_per_image},
                        {"features", extract.max_features},
                        {"format", 2}};  // 1: as many as COLMAP left
  for (size_t i = 0; i < photos.size(); ++i)
    key["photos"].push_back({linked.names[i], photos[i].sha256});
  const std::string text = key.dump();
  return Sha256({reinterpret_cast<const uint8_t*>(text.data()), text.size()}).substr(0, 16);
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

fs::path ModelWithMostPictures(const std::vector<fs::path>& folders, ColmapModel& best) {
  fs::path chosen;
  for (const fs::path& folder : folders) {
    ColmapModel model = ReadColmapModel(folder);
    LogInfo("model {}: {} pictures, {} points", folder.filename().string(), model.images.size(),
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

// Gives the model's pictures the photos' own names.
void Rename(ColmapModel& model, const LinkedPhotos& linked, const std::vector<Photo>& photos) {
  for (auto& [id, image] : model.images) {
    const auto found = linked.photo_of_name.find(image.name);
    if (found == linked.photo_of_name.end()) {
      throw DataError(
          fmt::format("COLMAP's model holds the picture {}, which is none of ours", image.name));
    }
    image.name = photos[found->second].name;
  }
}

// Features, matches and model, from the cache as far as they are there.
ColmapModel RunColmap(const SfmOptions& options, const std::vector<Photo>& photos, Stage& stage) {
  const ColmapProgram colmap = FindColmap(stage.folder() / "log.txt");
  LogInfo("COLMAP {}: {} pictures", colmap.version, photos.size());
  stage.Note("colmap", colmap.version);
  const fs::path scratch = stage.Scratch("work");
  const LinkedPhotos linked =
      LinkPhotos(stage.Input("PHOTOS"), photos, options.camera_sharing, scratch / "photos");
  const ExtractOptions extract{CameraModelFor(options, photos.size(), linked.cameras),
                               options.camera_sharing == "per-image", options.max_features};
  const fs::path cache =
      stage.Cache("colmap") / FeaturesKey(photos, linked, extract, colmap.version);
  fs::create_directories(cache);
  const fs::path features = cache / "features.db", database = cache / (options.matcher + ".db");

  Timer timer;
  if (!fs::exists(features)) {
    ExtractFeatures(colmap, linked.folder, linked.names, extract, cache / "parts", features);
    fs::remove_all(cache / "parts");
  }
  if (!fs::exists(database)) CopyDatabase(features, database);
  stage.Seconds("features", timer.seconds());

  timer = {};
  const PairChoice choice = options.matcher == "auto"         ? PairChoice::kAuto
                            : options.matcher == "sequential" ? PairChoice::kSequential
                                                              : PairChoice::kExhaustive;
  const MatchCounts matches = MatchFeatures(colmap, database, choice, scratch);
  LogInfo("{} matches in {} pairs", WithThousands(matches.matches), WithThousands(matches.pairs));
  stage.Count("pairs", matches.pairs);
  stage.Count("matches", matches.matches);
  stage.Seconds("matching", timer.seconds());

  timer = {};
  const fs::path finished = cache / fmt::format("mapped-{}-{}", options.matcher, options.seed);
  if (!fs::exists(finished)) {
    const fs::path models = scratch / "models";
    fs::remove_all(models);
    fs::create_directories(models);
    const std::vector<fs::path> folders =
        MapScene(colmap, linked.folder, database, photos.size(), options.seed, models);
    if (folders.empty()) {
      throw DataError(fmt::format(
          "COLMAP found no model: the {} pictures do not overlap enough, or were taken from almost "
          "one place; take photos of one scene from many places, each sharing most of what it "
          "shows with the next",
          photos.size()));
    }
    ColmapModel best;
    const fs::path chosen = ModelWithMostPictures(folders, best);
    stage.Count("models", folders.size());
    fs::rename(chosen, finished);
  }
  stage.Seconds("mapping", timer.seconds());
  ColmapModel model = ReadColmapModel(finished);
  Rename(model, linked, photos);
  return model;
}

// One of those that the camera took; their folder where it took none.
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
    const ColmapCamera& lens = camera;
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
  std::sort(scene.views.begin(), scene.views.end(),
            [](const View& a, const View& b) { return a.name < b.name; });
  for (size_t i = 0; i < scene.views.size(); ++i) {
    const bool held_out = options.holdout > 0 && i % size_t(options.holdout) == 0;
    scene.views[i].split = held_out ? Split::kTest : Split::kTrain;
  }
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

void WriteViews(const Scene& scene, const ColmapModel& model, const fs::path& photos,
                const fs::path& folder) {
  std::map<std::string, const ColmapCamera*> camera_of;
  for (const auto& [id, image] : model.images)
    camera_of[image.name] = &model.cameras.at(image.camera);
  for (const View& view : scene.views) fs::create_directories((folder / view.image).parent_path());
  Progress progress("undistorting: picture", double(scene.views.size()));
  std::mutex mutex;
  size_t done = 0, with_alpha = 0;
  ParallelFor(scene.views.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      ThrowIfStopRequested("COLMAP's results are kept");
      const View& view = scene.views[i];
      Image photo = ReadImage(photos / view.name);
      const bool alpha = photo.channels == 4;
      if (alpha) photo = WithoutAlpha(photo);
      const ColmapCamera& lens = *camera_of.at(view.name);
      NamingLens(
          photos / view.name, lens,
          [&] { photo = Undistort(photo, lens, scene.cameras[size_t(view.camera)]); }, kLensAdvice);
      WriteImage(folder / view.image, photo);
      const std::scoped_lock lock(mutex);
      with_alpha += alpha;
      progress.Update(double(++done));
    }
  });
  if (with_alpha > 0) {
    LogWarning(
        "{} pictures have transparency, which photos have no use for: it was dropped, the colours "
        "beneath were kept",
        with_alpha);
  }
}

void Report(const ModelQuality& quality, const Scene& scene,
            const std::vector<std::string>& unregistered, const Subject& subject, Stage& stage) {
  LogInfo(
      "{} of {} pictures registered, {} points, mean reprojection error {:.3f} px, mean track "
      "length {:.2f}",
      quality.registered, quality.photos, WithThousands(quality.points), quality.mean_error_px,
      quality.mean_track_length);
  if (!unregistered.empty()) {
    LogWarning("{} pictures are not registered and left out: {}", unregistered.size(),
               fmt::join(unregistered, ", "));
  }
  const glm::dvec3 size = subject.bounds_in_world.Size();
  LogInfo(
      "subject: {:.2f} x {:.2f} x {:.2f} units, from {} points; {} views to train on, {} held out",
      size.x, size.y, size.z, WithThousands(subject.points), scene.ViewsOf(Split::kTrain).size(),
      scene.ViewsOf(Split::kTest).size());
  stage.Count("photos", quality.photos);
  stage.Count("registered", quality.registered);
  stage.Count("points", quality.points);
  stage.Count("subject_points", subject.points);
  stage.Count("train_views", scene.ViewsOf(Split::kTrain).size());
  stage.Count("test_views", scene.ViewsOf(Split::kTest).size());
  stage.Count("mean_reprojection_error_px", quality.mean_error_px);
  stage.Count("mean_track_length", quality.mean_track_length);
  stage.Note("unregistered", unregistered);
  stage.Note("resolution", {scene.cameras.front().width, scene.cameras.front().height});
}

std::vector<std::string> Unregistered(const ColmapModel& model,
                                      const std::vector<std::string>& photo_names) {
  std::set<std::string> registered;
  for (const auto& [id, image] : model.images) registered.insert(image.name);
  std::vector<std::string> missing;
  for (const std::string& name : photo_names) {
    if (!registered.contains(name)) missing.push_back(name);
  }
  return missing;
}

}  // namespace

void CheckSfmOptions(const SfmOptions& options) {
  CheckOneOf(options.matcher, kMatchers, "--matcher");
  CheckOneOf(options.camera_sharing, kSharings, "--camera-sharing");
  CheckOneOf(options.camera_model, kModels, "--camera-model");
  CheckRange(options.max_features, 100, 100000, "--max-features");
  CheckRange(options.max_size, 16, 16384, "--max-size");
  CheckRange(options.holdout, 0, 1000000, "--holdout");
  if (options.holdout == 1)
    throw UsageError("--holdout is 1, which leaves no view to train on; expected 0 or at least 2");
  CheckRange(options.seed, 0, 1 << 30, "--seed");
}

std::vector<Photo> FindPhotos(const fs::path& folder) {
  const std::vector<std::string> names = PhotoNames(folder);
  if (names.empty()) {
    throw DataError(fmt::format(
        "{}: holds no photos (.jpg, .jpeg or .png); convert others to these", folder.string()));
  }
  if (names.size() == 1) {
    throw DataError(fmt::format(
        "{}: holds only one photo ({}); take at least 3 of the same scene, better 20 or more",
        folder.string(), names[0]));
  }
  std::vector<Photo> photos(names.size());
  std::vector<std::string> errors(names.size());
  Progress progress("checking: picture", double(names.size()));
  std::mutex mutex;
  size_t done = 0;
  ParallelFor(names.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      ThrowIfStopRequested("nothing was done yet");
      try {
        const Image image = ReadImage(folder / names[i]);
        photos[i] = {names[i], image.width, image.height, Sha256OfFile(folder / names[i])};
      } catch (const DataError& error) {
        errors[i] = error.what();
      }
      const std::scoped_lock lock(mutex);
      progress.Update(double(++done));
    }
  });
  std::vector<std::string> told;
  for (const std::string& error : errors) {
    if (!error.empty()) told.push_back(error);
  }
  if (!told.empty()) {
    throw DataError(fmt::format("{} of {} pictures cannot be read; replace or remove: {}",
                                told.size(), names.size(), fmt::join(told, "; ")));
  }
  return photos;
}

ModelQuality JudgeModel(const ColmapModel& model, const std::vector<std::string>& photo_names) {
  ModelQuality quality{model.images.size(), photo_names.size(), model.points.size(),
                       MeanReprojectionError_px(model), MeanTrackLength(model)};
  const std::vector<std::string> missing = Unregistered(model, photo_names);
  if (double(quality.registered) < kMinRegisteredShare * double(quality.photos)) {
    throw DataError(fmt::format(
        "only {} of {} pictures could be registered ({:.0f} % are needed); not registered: {}; add "
        "photos between these "
        "and the others, or remove them",
        quality.registered, quality.photos, 100 * kMinRegisteredShare, ShortList(missing)));
  }
  if (quality.points < kMinPoints) {
    throw DataError(fmt::format(
        "only {} points were found, {} are needed; take more photos, with more overlap, of "
        "surfaces with texture",
        quality.points, kMinPoints));
  }
  double longest = 0;
  for (const auto& [id, camera] : model.cameras)
    longest = std::max(longest, double(std::max(camera.width, camera.height)));
  const double max_error_px = kMaxError_px * std::max(1.0, longest / kErrorSize_px);
  if (quality.mean_error_px > max_error_px) {
    throw DataError(fmt::format(
        "the mean reprojection error is {:.2f} px, at most {:.2f} is good enough; were zoom or "
        "camera changed? try --camera-sharing per-image",
        quality.mean_error_px, max_error_px));
  }
  if (quality.mean_track_length < kMinTrackLength) {
    throw DataError(fmt::format(
        "a point is seen in {:.2f} pictures on the average, {} are needed; take photos with "
        "more overlap",
        quality.mean_track_length, kMinTrackLength));
  }
  return quality;
}

void RunSfm(const SfmOptions& options, Stage& stage) {
  CheckSfmOptions(options);
  const fs::path folder = stage.Input("PHOTOS");
  Timer timer;
  const std::vector<Photo> photos = FindPhotos(folder);
  stage.Seconds("check", timer.seconds());
  const ColmapModel model = RunColmap(options, photos, stage);
  std::vector<std::string> names;
  for (const Photo& photo : photos) names.push_back(photo.name);
  const ModelQuality quality = JudgeModel(model, names);

  timer = {};
  Scene scene = SceneFromModel(model, folder, options);
  const Subject subject = FindSubject(scene);
  MoveToSubject(scene, subject);
  stage.Output("images");
  WriteViews(scene, model, folder, stage.folder());
  WriteScene(stage.folder(), scene);
  stage.Output("scene.json");
  stage.Output("points.ply");
  stage.Seconds("undistort", timer.seconds());
  Report(quality, scene, Unregistered(model, names), subject, stage);
}

}  // namespace tetrec
