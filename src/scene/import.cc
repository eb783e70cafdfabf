// Import of data sets with known cameras.
#include "scene/import.h"

#include "core/error.h"
#include "core/log.h"
#include "core/parallel.h"
#include "core/progress.h"
#include "geometry/rotation.h"
#include "scene/carve.h"
#include "scene/colmap_undistort.h"
#include "scene/image.h"
#include "scene/sfm_bounds.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>

namespace tetrec {
namespace {

// What is kept of a picture once it is written.
struct StoredPicture {
  Camera camera;
  bool has_alpha = false, resized = false, lens_scaled = false, cut_to_plane = false;
  std::vector<uint8_t> alpha;  // training pictures only
};

// Relative to the scene folder.
std::string ImageOf(const PosedPicture& picture) {
  return picture.image.empty() ? "images/" + picture.name + ".png" : picture.image;
}

// Square pixels, the principal point in the middle.
ColmapCamera LensOfFieldOfView(double horizontal_fov_rad, const Image& image) {
  const double focal_px = 0.5 * image.width / std::tan(0.5 * horizontal_fov_rad);
  return {kColmapPinhole,
          uint64_t(image.width),
          uint64_t(image.height),
          {focal_px, focal_px, 0.5 * image.width, 0.5 * image.height}};
}

bool IsOfItsSize(const PosedPicture& picture, const Image& image) {
  return picture.lens.width == 0 || (uint64_t(image.width) == picture.lens.width &&
                                     uint64_t(image.height) == picture.lens.height);
}

// Data sets come with smaller copies of the pictures, their sides rounded up or down.
bool IsScaledCopy(const ColmapCamera& lens, const Image& image) {
  const double shape = double(lens.height) / double(lens.width);
  return std::abs(image.height - shape * image.width) <= std::max(1.0, shape);
}

ColmapCamera LensOf(const PosedPicture& picture, const Image& image) {
  if (picture.lens.width == 0) return LensOfFieldOfView(picture.horizontal_fov_rad, image);
  if (IsOfItsSize(picture, image)) return picture.lens;
  if (IsScaledCopy(picture.lens, image)) {
    return ScaledLens(picture.lens, image.width, image.height);
  }
  throw DataError(fmt::format(
      "{} has {} x {} pixels, its camera {} x {}, which is another shape; give the pictures that "
      "the cameras belong to",
      picture.file.string(), image.width, image.height, picture.lens.width, picture.lens.height));
}

// Both sides are rounded.
Camera Scaled(const ColmapCamera& pinhole, const glm::ivec2& size) {
  const double x = size.x / double(pinhole.width), y = size.y / double(pinhole.height);
  const std::vector<double>& p = pinhole.params;
  return {size.x, size.y, p[0] * x, p[1] * y, p[2] * x, p[3] * y};
}

// Brings a picture to a pinhole camera and to size, stores it under images/NAME.png.
StoredPicture StorePicture(const PosedPicture& picture, const std::filesystem::path& folder,
                           int max_size) {
  Image image = ReadImage(picture.file);
  const ColmapCamera lens = LensOf(picture, image);
  StoredPicture stored;
  stored.lens_scaled = !IsOfItsSize(picture, image);
  if (lens.model == kColmapPinhole) {
    const glm::ivec2 size = FitToMaxSize(image.width, image.height, max_size);
    stored.camera = Scaled(lens, size);
    stored.resized = size != glm::ivec2(image.width, image.height);
    if (stored.resized) image = ResizeByArea(image, size.x, size.y);
  } else {
    stored.camera =
        UndistortedCamera(lens, max_size == 0 ? std::max(image.width, image.height) : max_size);
    stored.resized = true;
    stored.cut_to_plane = IsTooWideForPlane(lens);
    image = Undistort(image, lens, stored.camera);
  }
  const std::filesystem::path path = folder / ImageOf(picture);
  std::filesystem::create_directories(path.parent_path());
  WriteImage(path, image);
  stored.has_alpha = image.channels == 4;
  if (stored.has_alpha && picture.split == Split::kTrain) stored.alpha = AlphaOf(image);
  return stored;
}

std::vector<StoredPicture> StorePictures(const std::vector<PosedPicture>& pictures,
                                         const std::filesystem::path& folder, int max_size) {
  constexpr size_t kBlock = 16;  // between two looks at the user's wish to stop
  std::vector<StoredPicture> stored(pictures.size());
  Progress progress("pictures", double(pictures.size()));
  for (size_t first = 0; first < pictures.size(); first += kBlock) {
    ThrowIfStopRequested("nothing is kept");
    const size_t count = std::min(kBlock, pictures.size() - first);
    ParallelFor(count, 1, [&](size_t begin, size_t end) {
      for (size_t i = first + begin; i < first + end; ++i) {
        stored[i] = StorePicture(pictures[i], folder, max_size);
      }
    });
    progress.Update(double(first + count));
  }
  return stored;
}

void CheckAlike(const std::vector<PosedPicture>& pictures,
                const std::vector<StoredPicture>& stored) {
  for (size_t i = 1; i < stored.size(); ++i) {
    if (stored[i].has_alpha == stored[0].has_alpha) continue;
    throw DataError(
        fmt::format("{} has {} alpha channel, {} has {}; all pictures of a data set must be alike",
                    pictures[i].file.string(), stored[i].has_alpha ? "an" : "no",
                    pictures[0].file.string(), stored[0].has_alpha ? "one" : "none"));
  }
}

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

void HoldOut(std::vector<PosedPicture>& pictures, int every) {
  std::sort(pictures.begin(), pictures.end(),
            [](const PosedPicture& a, const PosedPicture& b) { return a.name < b.name; });
  for (size_t i = 0; i < pictures.size(); ++i) {
    const bool held_out = every > 0 && i % size_t(every) == 0;
    pictures[i].split = held_out ? Split::kTest : Split::kTrain;
  }
}

// The data set as a scene, still in the input's frame.
Scene SceneInInput(const Dataset& set, const std::vector<StoredPicture>& stored) {
  Scene scene;
  scene.has_alpha = stored[0].has_alpha;
  scene.points = set.points;
  for (size_t i = 0; i < set.pictures.size(); ++i) {
    const PosedPicture& picture = set.pictures[i];
    View view;
    view.name = picture.name;
    view.image = ImageOf(picture);
    view.camera = IndexOfCamera(scene.cameras, stored[i].camera);
    view.cam_from_world = picture.cam_from_input;
    view.split = picture.split;
    scene.views.push_back(std::move(view));
  }
  return scene;
}

// Of pictures without points.
Bounds3 SubjectBoundsInInput(const Dataset& set, std::vector<StoredPicture>& stored) {
  std::vector<AlphaMask> masks;
  for (size_t i = 0; i < set.pictures.size(); ++i) {
    if (set.pictures[i].split != Split::kTrain) continue;
    masks.push_back({stored[i].camera, set.pictures[i].cam_from_input, std::move(stored[i].alpha)});
  }
  if (stored[0].has_alpha) return FindSubjectBounds(masks);
  if (set.box_in_input) return *set.box_in_input;
  LogWarning(
      "the pictures have neither alpha nor points: the subject's bounds are what all training "
      "cameras see");
  return BoxSeenByAll(masks);
}

// Centre 0, longest side 2.
Similarity3 InputFromWorld(const Bounds3& bounds_in_input) {
  const glm::dvec3 size = bounds_in_input.Size();
  return {0.5 * std::max({size.x, size.y, size.z}), glm::dmat3(1.0), bounds_in_input.Center()};
}

std::string Text(const glm::dvec3& v) {
  return fmt::format("({:.3f}, {:.3f}, {:.3f})", v.x, v.y, v.z);
}

// The axes stay those of the input.
void MoveToBounds(Scene& scene, const Bounds3& bounds_in_input) {
  LogInfo("subject in the input's coordinates: {} to {}", Text(bounds_in_input.min),
          Text(bounds_in_input.max));
  scene.input_from_world = InputFromWorld(bounds_in_input);
  const Similarity3 world_from_input = scene.input_from_world.Inverse();
  scene.subject_bounds = {world_from_input * bounds_in_input.min,
                          world_from_input * bounds_in_input.max};
  for (View& view : scene.views) {
    view.cam_from_world = CamFromWorld(view.cam_from_world, scene.input_from_world);
  }
  for (ScenePoint& point : scene.points) point.position = world_from_input * point.position;
}

Triangulation Triangulate(const std::filesystem::path& folder, const Scene& scene,
                          const std::vector<StoredPicture>& stored, const ColmapPlace& place) {
  if (!scene.points.empty()) {
    LogWarning("the data set has {} points of its own; --triangulate replaces them",
               scene.points.size());
  }
  ViewAlphas alphas;
  for (const StoredPicture& picture : stored) alphas.push_back(picture.alpha);
  return TriangulatePoints(folder, scene, alphas, place);
}

Background BackgroundOf(const Scene& scene, const ImportOptions& options) {
  if (scene.has_alpha && options.background == Background::kScene) {
    throw DataError(
        "--background scene: the pictures have alpha, behind which stands white or black");
  }
  return options.background.value_or(scene.has_alpha ? Background::kWhite : Background::kScene);
}

}  // namespace

void ImportOptions::Check() const {
  if (max_size < 0 || max_size > 65536) {
    throw UsageError(fmt::format("--max-size {}: expected 0 to 65536 pixels", max_size));
  }
  if (holdout < 0 || holdout == 1 || holdout > 1000000) {
    throw UsageError(fmt::format("--holdout {}: expected 0 or 2 to 1000000", holdout));
  }
}

glm::ivec2 FitToMaxSize(int width, int height, int max_size) {
  const int longer = std::max(width, height);
  if (max_size == 0 || longer <= max_size) return {width, height};
  const double scale = double(max_size) / longer;
  return {std::max(1, int(std::lround(width * scale))),
          std::max(1, int(std::lround(height * scale)))};
}

ImportedScene ImportDataset(const std::filesystem::path& dataset,
                            const std::filesystem::path& folder, const ImportOptions& options,
                            const ColmapPlace& place) {
  options.Check();
  Dataset set = ReadDataset(dataset, options.format, options.images);
  if (set.pictures.empty()) {
    throw DataError(fmt::format("{}: the data set has no pictures", dataset.string()));
  }
  if (!set.has_split) HoldOut(set.pictures, options.holdout);
  std::vector<StoredPicture> stored = StorePictures(set.pictures, folder, options.max_size);
  CheckAlike(set.pictures, stored);

  ImportedScene imported;
  imported.missing_files = set.missing_files;
  imported.remarks = set.remarks;
  for (const StoredPicture& picture : stored) {
    imported.resized += picture.resized;
    imported.lenses_scaled += picture.lens_scaled;
    imported.cut_to_plane += picture.cut_to_plane;
  }
  Scene& scene = imported.scene;
  scene = SceneInInput(set, stored);
  scene.background = BackgroundOf(scene, options);
  if (options.triangulate) {
    imported.triangulation = Triangulate(folder, scene, stored, place);
    scene.points = imported.triangulation->points;
  }
  if (!scene.has_alpha && !scene.points.empty()) {
    MoveToSubject(scene, FindSubject(scene));
  } else {
    MoveToBounds(scene, SubjectBoundsInInput(set, stored));
  }
  if (options.triangulate && scene.has_alpha) {
    imported.points_out_of_bounds = std::erase_if(scene.points, [&](const ScenePoint& point) {
      return !scene.subject_bounds.Contains(point.position);
    });
  }
  WriteScene(folder, scene);
  return imported;
}

void RunImport(const ImportOptions& options, Stage& stage) {
  const Timer timer;
  stage.Output("scene.json");
  stage.Output("images");
  const ColmapPlace place =
      options.triangulate
          ? ColmapPlace{stage.folder() / "log.txt", stage.Cache("colmap"), stage.Scratch("work")}
          : ColmapPlace{};
  const ImportedScene imported =
      ImportDataset(stage.Input("DATASET"), stage.folder(), options, place);
  const Scene& scene = imported.scene;
  if (!scene.points.empty()) stage.Output("points.ply");
  for (const std::string& file : imported.missing_files) {
    LogWarning("{} is not there; the scene goes without it", file);
  }
  for (const std::string& remark : imported.remarks) LogWarning("{}", remark);
  if (imported.lenses_scaled > 0) {
    LogInfo("{} pictures have another size than their cameras: the cameras are scaled to them",
            imported.lenses_scaled);
  }
  if (imported.cut_to_plane > 0) {
    LogWarning("{} pictures show more than 60 degrees to a side and are cut there",
               imported.cut_to_plane);
  }
  const Camera& camera = scene.cameras[0];
  LogInfo("{} training, {} validation, {} test views; {} x {} pixels; {} resized",
          scene.ViewsOf(Split::kTrain).size(), scene.ViewsOf(Split::kValidation).size(),
          scene.ViewsOf(Split::kTest).size(), camera.width, camera.height, imported.resized);
  stage.Count("train_views", scene.ViewsOf(Split::kTrain).size());
  stage.Count("validation_views", scene.ViewsOf(Split::kValidation).size());
  stage.Count("test_views", scene.ViewsOf(Split::kTest).size());
  if (const auto& triangulation = imported.triangulation) {
    LogInfo("{} triangulated points are outside of the subject's bounds and dropped",
            imported.points_out_of_bounds);
    stage.Count("points_triangulated", triangulation->found);
    stage.Count("points_dropped_weak", triangulation->weak);
    stage.Count("points_dropped_transparent", triangulation->transparent);
    stage.Count("points_dropped_out_of_bounds", imported.points_out_of_bounds);
  }
  stage.Count("points", scene.points.size());
  stage.Count("cameras", scene.cameras.size());
  stage.Count("pictures_resized", imported.resized);
  stage.Count("lenses_scaled", imported.lenses_scaled);
  stage.Count("pictures_cut_to_plane", imported.cut_to_plane);
  stage.Note("missing_files", imported.missing_files);
  stage.Seconds("import", timer.seconds());
}

}  // namespace tetrec
