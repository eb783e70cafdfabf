// Import of data sets with known cameras.
#include "scene/import.h"

#include "core/error.h"
#include "core/file.h"
#include "core/log.h"
#include "core/parallel.h"
#include "core/progress.h"
#include "core/short_list.h"
#include "geometry/rotation.h"
#include "scene/carve.h"
#include "scene/colmap_undistort.h"
#include "scene/image.h"
#include "scene/sfm_bounds.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <sstream>

namespace tetrec {
namespace {

constexpr uint64_t kMaxListBytes = uint64_t{1} << 26;
constexpr double kFarthest = 1e9;

// Drops masks that are not wanted; else all pictures must have one, or none.
void ChooseMasks(std::vector<PosedPicture>& pictures, MaskUse use) {
  std::vector<std::string> without;
  for (PosedPicture& picture : pictures) {
    if (use == MaskUse::kNone) picture.mask.clear();
    if (picture.mask.empty()) without.push_back(picture.name);
  }
  if (without.empty() || without.size() == pictures.size()) return;
  throw DataError(fmt::format(
      "{} of {} pictures have no mask: {}; give each one, white where all is seen, or use none of "
      "them by --masks none",
      without.size(), pictures.size(), ShortList(without)));
}

// What is kept of a picture once it is written.
struct StoredPicture {
  Camera camera;
  bool has_alpha = false;      // of opacity
  bool has_mask = false;       // alpha that leaves pixels out
  uint64_t hidden_pixels = 0;  // by either, at least in part
  uint64_t masked_pixels = 0;
  bool resized = false, turned = false, lens_scaled = false;
  bool cut_to_plane = false;
  uint64_t clipped_pixels = 0;
  std::vector<uint8_t> alpha;  // training pictures only
};

// Relative to the scene folder.
std::string ImageOf(const PosedPicture& picture) {
  return picture.image.empty() ? "images/" + picture.name + ".png" : picture.image;
}

// The principal point in the middle.
ColmapCamera LensOfFieldOfView(const PosedPicture& picture, const Image& image) {
  const auto focal_px = [](double fov_rad, int size) {
    return fov_rad == 0 ? 0.0 : 0.5 * size / std::tan(0.5 * fov_rad);
  };
  const double fx = focal_px(picture.horizontal_fov_rad, image.width);
  const double fy = focal_px(picture.vertical_fov_rad, image.height);
  return {kColmapPinhole,
          uint64_t(image.width),
          uint64_t(image.height),
          {fx == 0 ? fy : fx, fy == 0 ? fx : fy, 0.5 * image.width, 0.5 * image.height}};
}

glm::ivec2 SizeOf(const Image& image) { return {image.width, image.height}; }

// Data sets come with smaller copies of the pictures, their sides rounded up or down.
bool IsScaledCopy(const glm::ivec2& copy, const glm::ivec2& original) {
  const double shape = double(original.y) / original.x;
  const bool both_sides_scaled =
      (copy.x < original.x && copy.y < original.y) || (copy.x > original.x && copy.y > original.y);
  return both_sides_scaled && std::abs(copy.y - shape * copy.x) <= std::max(1.0, shape);
}

// As its camera sees it, or a scaled copy; notes what was done to it.
Image ReadPicture(const PosedPicture& picture, StoredPicture& stored) {
  Image image = ReadImage(picture.file, ExifRotation::kIgnore, &stored.clipped_pixels);
  const glm::ivec2 wanted(picture.lens.width, picture.lens.height), size = SizeOf(image);
  if (wanted.x == 0 || size == wanted) return image;
  if (glm::ivec2(size.y, size.x) == wanted) {
    Image turned = ReadImage(picture.file, ExifRotation::kApply);
    stored.turned = SizeOf(turned) == wanted && turned.channels == image.channels;
    if (stored.turned) return turned;
  }
  stored.lens_scaled = IsScaledCopy(size, wanted);
  if (stored.lens_scaled) return image;
  throw DataError(fmt::format(
      "{} has {} x {} pixels, its camera {} x {}, which is another shape; give the pictures that "
      "the cameras belong to",
      picture.file.string(), size.x, size.y, wanted.x, wanted.y));
}

ColmapCamera LensOf(const PosedPicture& picture, const Image& image, bool is_scaled) {
  if (picture.lens.width == 0) return LensOfFieldOfView(picture, image);
  return is_scaled ? ScaledLens(picture.lens, image.width, image.height) : picture.lens;
}

bool IsOpaque(const Image& image) {
  if (image.channels != 4) return true;
  for (size_t i = 3; i < image.pixels.size(); i += 4) {
    if (image.pixels[i] != 255) return false;
  }
  return true;
}

Image ReadAndApplyMask(const PosedPicture& picture, const Image& image, MaskUse use) {
  if (use == MaskUse::kIgnore && !IsOpaque(image)) {
    throw DataError(fmt::format(
        "{} has alpha and the mask {}; say what the mask means: --masks subject (what is black "
        "there is empty too) or --masks none",
        picture.file.string(), picture.mask.string()));
  }
  const Image mask = ReadImage(picture.mask);
  if (SizeOf(mask) != SizeOf(image) && !IsScaledCopy(SizeOf(mask), SizeOf(image))) {
    throw DataError(fmt::format("{}: mask of {} x {} pixels for {} of {} x {}; expected one shape",
                                picture.mask.string(), mask.width, mask.height,
                                picture.file.string(), image.width, image.height));
  }
  return MaskedBy(image, mask);
}

// The longer side of the working picture [px].
int LongerSide(const Image& image, const ImportOptions& options) {
  const int longer = std::max(image.width, image.height);
  if (options.downscale) return std::max(1, int(std::lround(longer / *options.downscale)));
  return options.max_size == 0 ? longer : std::min(longer, options.max_size);
}

// Both sides are rounded.
Camera Scaled(const ColmapCamera& pinhole, const glm::ivec2& size) {
  const double x = size.x / double(pinhole.width), y = size.y / double(pinhole.height);
  const std::vector<double>& p = pinhole.params;
  return {size.x, size.y, p[0] * x, p[1] * y, p[2] * x, p[3] * y};
}

void CountHidden(const std::vector<uint8_t>& alpha, StoredPicture& stored) {
  for (const uint8_t value : alpha) {
    stored.hidden_pixels += value != 255;
    stored.masked_pixels += value < kSeenAlpha;
  }
}

// Brings a picture to a pinhole camera and to size, stores it under images/NAME.png.
StoredPicture StorePicture(const PosedPicture& picture, const std::filesystem::path& folder,
                           const ImportOptions& options) {
  StoredPicture stored;
  Image image = ReadPicture(picture, stored);
  const bool is_masked = !picture.mask.empty();
  if (is_masked) image = ReadAndApplyMask(picture, image, options.masks);
  const ColmapCamera lens = LensOf(picture, image, stored.lens_scaled);
  const int longer_side = LongerSide(image, options);
  if (lens.model == kColmapPinhole) {
    const glm::ivec2 size = FitToMaxSize(image.width, image.height, longer_side);
    stored.camera = Scaled(lens, size);
    stored.resized = size != glm::ivec2(image.width, image.height);
    if (stored.resized) image = ResizeByArea(image, size.x, size.y);
  } else {
    NamingLens(picture.file, lens, [&] {
      stored.camera = UndistortedCamera(lens, longer_side);
      stored.resized = true;
      stored.cut_to_plane = IsTooWideForPlane(lens);
      image = Undistort(image, lens, stored.camera);
    });
  }
  const std::filesystem::path path = folder / ImageOf(picture);
  std::filesystem::create_directories(path.parent_path());
  WriteImage(path, image);
  stored.has_mask = is_masked && options.masks == MaskUse::kIgnore;
  stored.has_alpha = image.channels == 4 && !stored.has_mask;
  if (image.channels != 4) return stored;
  std::vector<uint8_t> alpha = AlphaOf(image);
  CountHidden(alpha, stored);
  if (stored.has_alpha && picture.split == Split::kTrain) stored.alpha = std::move(alpha);
  return stored;
}

std::vector<StoredPicture> StorePictures(const std::vector<PosedPicture>& pictures,
                                         const std::filesystem::path& folder,
                                         const ImportOptions& options) {
  constexpr size_t kBlock = 16;  // between two looks at the user's wish to stop
  std::vector<StoredPicture> stored(pictures.size());
  Progress progress("pictures", double(pictures.size()));
  for (size_t first = 0; first < pictures.size(); first += kBlock) {
    ThrowIfStopRequested("nothing is kept");
    const size_t count = std::min(kBlock, pictures.size() - first);
    ParallelFor(count, 1, [&](size_t begin, size_t end) {
      for (size_t i = first + begin; i < first + end; ++i) {
        stored[i] = StorePicture(pictures[i], folder, options);
      }
    });
    progress.Update(double(first + count));
  }
  return stored;
}

// Alpha that hides nothing in any picture, as of screenshots, is none: drops it. Returns of how
// many pictures.
size_t DropIdleAlpha(const std::vector<PosedPicture>& pictures, const std::filesystem::path& folder,
                     std::vector<StoredPicture>& stored) {
  const bool hides = std::any_of(stored.begin(), stored.end(), [](const StoredPicture& picture) {
    return picture.hidden_pixels > 0;
  });
  if (hides) return 0;
  std::atomic<size_t> dropped = 0;
  ParallelFor(stored.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      if (!stored[i].has_alpha && !stored[i].has_mask) continue;
      const std::filesystem::path path = folder / ImageOf(pictures[i]);
      WriteImage(path, CompositeOver(ReadImage(path), 0, 0, 0));
      stored[i].has_alpha = stored[i].has_mask = false;
      stored[i].alpha.clear();
      ++dropped;
    }
  });
  return dropped;
}

void CheckAlike(const std::vector<PosedPicture>& pictures,
                const std::vector<StoredPicture>& stored) {
  for (size_t i = 1; i < stored.size(); ++i) {
    if (stored[i].has_alpha == stored[0].has_alpha && stored[i].has_mask == stored[0].has_mask)
      continue;
    throw DataError(fmt::format(
        "{} has {} alpha channel or mask, {} has {}; all pictures of a data set must be "
        "alike",
        pictures[i].file.string(), stored[i].has_alpha || stored[i].has_mask ? "an" : "no",
        pictures[0].file.string(), stored[0].has_alpha || stored[0].has_mask ? "one" : "none"));
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

// The picture that a line of the test list names: by its name, else by its file's, with or without
// extension and folder.
size_t FindListed(const std::vector<PosedPicture>& pictures, const std::string& line,
                  const std::string& where) {
  std::vector<size_t> found;
  for (size_t i = 0; i < pictures.size(); ++i) {
    const PosedPicture& picture = pictures[i];
    if (picture.name == line) return i;
    const std::filesystem::path& file = picture.file;
    const bool is_its_file = picture.name + file.extension().string() == line ||
                             std::filesystem::path(picture.name).replace_extension() == line ||
                             file.filename() == line || file.stem() == line;
    if (is_its_file) found.push_back(i);
  }
  if (found.empty()) {
    throw DataError(
        fmt::format("{}: no picture of the data set has the name \"{}\"; names are as "
                    "\"{}\"",
                    where, line, pictures[0].name));
  }
  if (found.size() > 1) {
    throw DataError(
        fmt::format("{}: \"{}\" is the name of {} pictures, as \"{}\" and \"{}\"; "
                    "write it in full",
                    where, line, found.size(), pictures[found[0]].name, pictures[found[1]].name));
  }
  return found[0];
}

void SplitByList(std::vector<PosedPicture>& pictures, const std::filesystem::path& list) {
  for (PosedPicture& picture : pictures) picture.split = Split::kTrain;
  std::istringstream lines(ReadText(list, kMaxListBytes));
  int number = 0, listed = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    line.erase(line.find_last_not_of(" \t\r") + 1);
    if (line.empty()) continue;
    const std::string where = fmt::format("{}: line {}", list.string(), number);
    pictures[FindListed(pictures, line, where)].split = Split::kTest;
    ++listed;
  }
  if (listed == 0) {
    throw DataError(
        fmt::format("{}: names no view; to hold out none use --holdout 0", list.string()));
  }
}

void ChooseSplit(Dataset& set, const ImportOptions& options) {
  constexpr int kUsualHoldout = 8;
  if (!options.test_list.empty()) {
    SplitByList(set.pictures, options.test_list);
  } else if (options.holdout || !set.has_split) {
    HoldOut(set.pictures, options.holdout.value_or(kUsualHoldout));
  }
  const bool has_training =
      std::any_of(set.pictures.begin(), set.pictures.end(),
                  [](const PosedPicture& picture) { return picture.split == Split::kTrain; });
  if (!has_training) {
    throw DataError(
        fmt::format("all {} pictures are held out; leave some to train on", set.pictures.size()));
  }
}

// Of points that came without their tracks: the training views whose picture they lie in, which is
// as many as can see them.
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
    view.image = ImageOf(picture);
    view.camera = IndexOfCamera(scene.cameras, stored[i].camera);
    view.cam_from_world = picture.cam_from_input;
    view.split = picture.split;
    scene.views.push_back(std::move(view));
  }
  CountTracks(scene);
  return scene;
}

std::string Text(const glm::dvec3& v) {
  return fmt::format("({:.3f}, {:.3f}, {:.3f})", v.x, v.y, v.z);
}

bool HoldsTrainingCamera(const Bounds3& box, const Dataset& set) {
  return std::any_of(set.pictures.begin(), set.pictures.end(), [&](const PosedPicture& picture) {
    return picture.split == Split::kTrain &&
           box.Contains(picture.cam_from_input.Inverse().translation);
  });
}

// Of pictures without points.
Bounds3 SubjectBoundsInInput(const Dataset& set, std::vector<StoredPicture>& stored) {
  std::vector<AlphaMask> masks;
  for (size_t i = 0; i < set.pictures.size(); ++i) {
    if (set.pictures[i].split != Split::kTrain) continue;
    masks.push_back({stored[i].camera, set.pictures[i].cam_from_input, std::move(stored[i].alpha)});
  }
  if (stored[0].has_alpha) return FindSubjectBounds(masks);
  if (set.box_in_input) {
    const Bounds3& box = *set.box_in_input;
    if (!HoldsTrainingCamera(box, set)) return box;
    LogInfo("the data set's box, {} to {}, holds cameras, and so more than the subject",
            Text(box.min), Text(box.max));
  }
  if (const std::optional<Bounds3> seen = BoxSeenByAll(masks)) {
    LogWarning(
        "the pictures have neither alpha nor points: the subject's bounds are what all training "
        "cameras see");
    return *seen;
  }
  const Bounds3 around = BoxAroundCameras(masks);
  LogWarning(
      "the pictures have neither alpha nor points, and the training cameras do not look at one "
      "place: the subject's bounds are a box around the cameras; --bounds tells another, "
      "--triangulate finds points that tell one");
  return around;
}

// Centre 0, longest side 2.
Similarity3 InputFromWorld(const Bounds3& bounds_in_input) {
  const glm::dvec3 size = bounds_in_input.Size();
  return {0.5 * std::max({size.x, size.y, size.z}), glm::dmat3(1.0), bounds_in_input.Center()};
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

ViewAlphas AlphasOf(const std::vector<StoredPicture>& stored) {
  ViewAlphas alphas;
  for (const StoredPicture& picture : stored) alphas.push_back(picture.alpha);
  return alphas;
}

Triangulation Triangulate(const std::filesystem::path& folder, const Scene& scene,
                          const std::vector<StoredPicture>& stored, const ColmapPlace& place) {
  if (!scene.points.empty()) {
    LogWarning("the data set has {} points of its own; --triangulate replaces them",
               scene.points.size());
  }
  return TriangulatePoints(folder, scene, AlphasOf(stored), place);
}

// Points of the data set that some training view sees through.
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
        "--background scene: the pictures have alpha, behind which stands white or black");
  }
  return options.background.value_or(scene.has_alpha ? Background::kWhite : Background::kScene);
}

}  // namespace

void ImportOptions::Check() const {
  if (max_size < 0 || max_size > 65536) {
    throw UsageError(fmt::format("--max-size {}: expected 0 to 65536 pixels", max_size));
  }
  if (downscale && !(*downscale >= 1 && *downscale <= 1024)) {
    throw UsageError(fmt::format("--downscale {}: expected 1 to 1024", *downscale));
  }
  if (holdout && (*holdout < 0 || *holdout == 1 || *holdout > 1000000)) {
    throw UsageError(fmt::format("--holdout {}: expected 0 or 2 to 1000000", *holdout));
  }
  if (subject_in_input) {
    const auto& [min, max] = *subject_in_input;
    const bool is_box = glm::all(glm::lessThan(min, max)) &&
                        glm::all(glm::lessThan(glm::abs(min), glm::dvec3(kFarthest))) &&
                        glm::all(glm::lessThan(glm::abs(max), glm::dvec3(kFarthest)));
    if (!is_box) {
      throw UsageError(fmt::format(
          "--bounds {},{},{},{},{},{}: expected x0,y0,z0,x1,y1,z1 with each x0 < x1, below {}",
          min.x, min.y, min.z, max.x, max.y, max.z, kFarthest));
    }
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
  Dataset set =
      ReadDataset(dataset, options.format, options.images,
                  options.skip_missing ? MissingPictures::kSkip : MissingPictures::kRefuse);
  if (set.pictures.empty()) {
    throw DataError(fmt::format("{}: the data set has no pictures", dataset.string()));
  }
  ChooseMasks(set.pictures, options.masks);
  ChooseSplit(set, options);
  std::vector<StoredPicture> stored = StorePictures(set.pictures, folder, options);

  ImportedScene imported;
  imported.opaque = DropIdleAlpha(set.pictures, folder, stored);
  CheckAlike(set.pictures, stored);
  if (stored[0].has_mask) imported.masked_share = MaskedShare(stored);
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
    imported.triangulation = Triangulate(folder, scene, stored, place);
    scene.points = imported.triangulation->points;
  } else if (scene.has_alpha) {
    imported.points_transparent = DropTransparentPoints(stored, scene);
  }
  if (options.subject_in_input) {
    MoveToBounds(scene, *options.subject_in_input);
  } else if (!scene.has_alpha && !scene.points.empty()) {
    MoveToSubject(scene, FindSubject(scene));
  } else {
    MoveToBounds(scene, SubjectBoundsInInput(set, stored));
  }
  if (scene.has_alpha) {
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
  ImportOptions with_list = options;
  if (stage.HasInput("test-list")) with_list.test_list = stage.Input("test-list");
  const ColmapPlace place =
      options.triangulate
          ? ColmapPlace{stage.folder() / "log.txt", stage.Cache("colmap"), stage.Scratch("work")}
          : ColmapPlace{};
  const ImportedScene imported =
      ImportDataset(stage.Input("DATASET"), stage.folder(), with_list, place);
  const Scene& scene = imported.scene;
  if (!scene.points.empty()) stage.Output("points.ply");
  for (const std::string& file : imported.missing_files) {
    LogWarning("{} is not there; the scene goes without it", file);
  }
  if (!imported.skipped.empty()) {
    LogWarning("pictures that are not there, left out: {}: {}", imported.skipped.size(),
               ShortList(imported.skipped));
  }
  if (imported.turned > 0) {
    LogWarning("pictures turned by their EXIF orientation, as their cameras are: {}",
               imported.turned);
  }
  if (imported.clipped_pixels > 0) {
    LogWarning("pixels too bright or dark for display, clipped: {}", imported.clipped_pixels);
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
  if (imported.opaque > 0) {
    LogInfo("{} pictures have alpha or masks that hide nothing in any of them: dropped",
            imported.opaque);
  }
  if (scene.has_masks) {
    LogInfo("masks leave out {:.1f} % of all pixels (--masks subject: what they hide is empty)",
            100 * imported.masked_share);
  }
  const Camera& camera = scene.cameras[0];
  LogInfo("{} training, {} validation, {} test views; {} x {} pixels; {} resized",
          scene.ViewsOf(Split::kTrain).size(), scene.ViewsOf(Split::kValidation).size(),
          scene.ViewsOf(Split::kTest).size(), camera.width, camera.height, imported.resized);
  stage.Count("train_views", scene.ViewsOf(Split::kTrain).size());
  stage.Count("validation_views", scene.ViewsOf(Split::kValidation).size());
  stage.Count("test_views", scene.ViewsOf(Split::kTest).size());
  if (const auto& triangulation = imported.triangulation) {
    stage.Count("points_triangulated", triangulation->found);
    stage.Count("points_dropped_weak", triangulation->weak);
    stage.Count("points_dropped_transparent", triangulation->transparent);
  } else if (imported.points_transparent > 0) {
    LogInfo("{} points lie where some training view sees through: dropped",
            imported.points_transparent);
    stage.Count("points_dropped_transparent", imported.points_transparent);
  }
  if (imported.points_out_of_bounds > 0) {
    LogInfo("{} points are outside of the subject's bounds: dropped",
            imported.points_out_of_bounds);
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
  stage.Seconds("import", timer.seconds());
}

}  // namespace tetrec
