// Import of data sets with known cameras.
#include "scene/import.h"

#include "core/error.h"
#include "core/log.h"
#include "core/parallel.h"
#include "core/progress.h"
#include "geometry/rotation.h"
#include "scene/carve.h"
#include "scene/image.h"
#include "scene/nerf_synthetic.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>

namespace tetrec {
namespace {

// What is kept of a picture once it is written.
struct StoredPicture {
  Camera camera;
  bool has_alpha = false, resized = false;
  std::vector<uint8_t> alpha;  // training pictures only
};

// Reads a picture, resizes it and stores it under images/NAME.png.
StoredPicture StorePicture(const PosedPicture& picture, const std::filesystem::path& folder,
                           int max_size) {
  const Image original = ReadImage(picture.file);
  const glm::ivec2 size = FitToMaxSize(original.width, original.height, max_size);
  const bool resized = size != glm::ivec2(original.width, original.height);
  const Image image = resized ? ResizeByArea(original, size.x, size.y) : original;

  const std::filesystem::path path = folder / ("images/" + picture.name + ".png");
  std::filesystem::create_directories(path.parent_path());
  WriteImage(path, image);

  // Square pixels of the original; both sides are rounded when it is resized.
  const double focal_px = 0.5 * original.width / std::tan(0.5 * picture.horizontal_fov_rad);
  StoredPicture stored;
  stored.camera = {size.x,
                   size.y,
                   focal_px * size.x / original.width,
                   focal_px * size.y / original.height,
                   0.5 * size.x,
                   0.5 * size.y};
  stored.has_alpha = image.channels == 4;
  stored.resized = resized;
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
           other.fy == camera.fy;
  };
  const auto found = std::find_if(cameras.begin(), cameras.end(), same);
  if (found != cameras.end()) return int(found - cameras.begin());
  cameras.push_back(camera);
  return int(cameras.size()) - 1;
}

Bounds3 SubjectBoundsInInput(const std::vector<PosedPicture>& pictures,
                             std::vector<StoredPicture>& stored) {
  std::vector<AlphaMask> masks;
  for (size_t i = 0; i < pictures.size(); ++i) {
    if (pictures[i].split != Split::kTrain) continue;
    masks.push_back({stored[i].camera, pictures[i].cam_from_input, std::move(stored[i].alpha)});
  }
  if (stored[0].has_alpha) return FindSubjectBounds(masks);
  LogWarning("the pictures have no alpha: the subject's bounds are what all training cameras see");
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

}  // namespace

void ImportOptions::Check() const {
  if (format != "nerf-synthetic") {
    throw UsageError(fmt::format("--format {}: expected nerf-synthetic", format));
  }
  if (max_size < 0 || max_size > 65536) {
    throw UsageError(fmt::format("--max-size {}: expected 0 to 65536 pixels", max_size));
  }
  if (background == Background::kScene) {
    throw UsageError("--background scene: pictures with alpha need white or black");
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
                            const std::filesystem::path& folder, const ImportOptions& options) {
  options.Check();
  const NerfSynthetic set = ReadNerfSynthetic(dataset);
  std::vector<StoredPicture> stored = StorePictures(set.pictures, folder, options.max_size);
  CheckAlike(set.pictures, stored);

  ImportedScene imported;
  imported.missing_splits = set.missing_splits;
  Scene& scene = imported.scene;
  scene.background = options.background;
  scene.has_alpha = stored[0].has_alpha;
  const Bounds3 bounds_in_input = SubjectBoundsInInput(set.pictures, stored);
  scene.input_from_world = InputFromWorld(bounds_in_input);
  const Similarity3 world_from_input = scene.input_from_world.Inverse();
  scene.subject_bounds = {world_from_input * bounds_in_input.min,
                          world_from_input * bounds_in_input.max};
  LogInfo("subject in the input's coordinates: {} to {}", Text(bounds_in_input.min),
          Text(bounds_in_input.max));

  for (size_t i = 0; i < set.pictures.size(); ++i) {
    const PosedPicture& picture = set.pictures[i];
    View view;
    view.name = picture.name;
    view.image = "images/" + picture.name + ".png";
    view.camera = IndexOfCamera(scene.cameras, stored[i].camera);
    view.cam_from_world = CamFromWorld(picture.cam_from_input, scene.input_from_world);
    view.split = picture.split;
    scene.views.push_back(std::move(view));
    imported.resized += stored[i].resized ? 1 : 0;
  }
  WriteScene(folder, scene);
  return imported;
}

void RunImport(const ImportOptions& options, Stage& stage) {
  const Timer timer;
  stage.Output("scene.json");
  stage.Output("images");
  const ImportedScene imported = ImportDataset(stage.Input("DATASET"), stage.folder(), options);
  const Scene& scene = imported.scene;
  for (const std::string& file : imported.missing_splits) {
    LogWarning("{} is not there; the scene goes without that split", file);
  }
  const Camera& camera = scene.cameras[0];
  LogInfo("{} training, {} validation, {} test views; {} x {} pixels; {} resized",
          scene.ViewsOf(Split::kTrain).size(), scene.ViewsOf(Split::kValidation).size(),
          scene.ViewsOf(Split::kTest).size(), camera.width, camera.height, imported.resized);
  stage.Count("train_views", scene.ViewsOf(Split::kTrain).size());
  stage.Count("validation_views", scene.ViewsOf(Split::kValidation).size());
  stage.Count("test_views", scene.ViewsOf(Split::kTest).size());
  stage.Count("cameras", scene.cameras.size());
  stage.Count("pictures_resized", imported.resized);
  stage.Note("missing_splits", imported.missing_splits);
  stage.Seconds("import", timer.seconds());
}

}  // namespace tetrec
