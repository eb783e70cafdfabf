// Sparse points for scenes with known cameras.
#include "sfm/triangulate.h"

#include "colmap/model.h"
#include "colmap/run.h"
#include "colmap/version.h"
#include "colmap/write_model.h"
#include "core/error.h"
#include "core/file.h"
#include "core/log.h"
#include "core/parallel.h"
#include "core/progress.h"
#include "image/image.h"
#include "sfm/work_key.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace tetrec {
namespace fs = std::filesystem;
namespace {

constexpr size_t kMinTrack = 3;
constexpr double kMaxPointError_px = 2;
constexpr int kMaxFeatures = 8192;  // per image; more than images of 800 px have

// The training views as COLMAP sees them: images CAMERA/VIEW.png, whose file names sort like the
// views.
struct Photos {
  fs::path folder;
  std::vector<int> views;  // indices into Scene::views
  std::vector<std::string> names;
};

Image ReadOpaque(const fs::path& path, Background background) {
  const Image image = ReadImage(path);
  if (image.channels == 3) return image;
  const uint8_t level = background == Background::kWhite ? 255 : 0;
  return CompositeOver(image, level, level, level);
}

Photos WritePhotos(const fs::path& folder, const Scene& scene, const fs::path& into) {
  Photos photos{into, scene.ViewsOf(Split::kTrain), {}};
  fs::remove_all(into);
  const size_t digits = std::to_string(scene.views.size()).size();
  for (const int view : photos.views) {
    const int camera = scene.views[size_t(view)].camera;
    photos.names.push_back(fmt::format("{}/{:0{}}.png", camera, view, digits));
    fs::create_directories((into / photos.names.back()).parent_path());
  }
  ParallelForEach(photos.views.size(), "", "nothing is kept", [&](size_t i) {
    const View& view = scene.views[size_t(photos.views[i])];
    WriteImage(into / photos.names[i], ReadOpaque(folder / view.image, scene.background));
  });
  return photos;
}

std::string MatchesKey(const Photos& photos, const ColmapProgram& colmap) {
  nlohmann::json key = {{"colmap", colmap.version}, {"features", kMaxFeatures}};
  for (const std::string& name : photos.names) {
    key["photos"].push_back({name, Sha256OfFile(photos.folder / name)});
  }
  return WorkKey(key);
}

// The scene's cameras as a COLMAP model without points; the ids are those of the database, from 1.
ColmapModel KnownCameras(const Scene& scene, const Photos& photos) {
  ColmapModel model;
  std::map<int, uint32_t> camera_ids;
  for (size_t i = 0; i < photos.views.size(); ++i) {
    const View& view = scene.views[size_t(photos.views[i])];
    const auto [id, is_new] = camera_ids.emplace(view.camera, uint32_t(camera_ids.size() + 1));
    if (is_new) model.cameras[id->second] = PinholeLens(scene.cameras[size_t(view.camera)]);
    model.images[uint32_t(i + 1)] = {
        .name = photos.names[i], .camera = id->second, .cam_from_world = view.cam_from_world};
  }
  return model;
}

// Checks that COLMAP's model is in the frame of the cameras that it was given.
void CheckUnmoved(const ColmapModel& model, const Scene& scene, const Photos& photos,
                  const ColmapProgram& colmap) {
  constexpr double kTolerance = 1e-9;  // quaternions normalised again
  for (const auto& [id, image] : model.images) {
    TETREC_CHECK(id >= 1 && id <= photos.views.size() && photos.names[id - 1] == image.name,
                 "COLMAP numbered the image " + image.name + " differently");
    const Rigid3& known = scene.views[size_t(photos.views[id - 1])].cam_from_world;
    double moved = 0;
    for (const glm::dvec3& point :
         {glm::dvec3(0, 0, 0), glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0)}) {
      moved = std::max(moved, glm::distance(image.cam_from_world * point, known * point));
    }
    if (moved <= kTolerance * (1 + glm::length(known.translation))) continue;
    throw EnvironmentError(
        fmt::format("colmap point_triangulator moved the known camera of {} by {:.2g}; {}",
                    image.name, moved, ColmapVersions(colmap.version)));
  }
}

// True if the view sees through the point: alpha is 0 at all four pixels around it. False outside
// the image, where nothing is known.
bool SeesThrough(const Camera& camera, const Rigid3& cam_from_world,
                 const std::vector<uint8_t>& alpha, const glm::dvec3& point) {
  const glm::dvec3 in_cam = cam_from_world * point;
  if (alpha.empty() || !(in_cam.z > 0)) return false;
  const glm::dvec2 corner = glm::floor(camera.ImageFromCam(in_cam) - 0.5);
  if (corner.x < 0 || corner.y < 0 || corner.x + 1 >= camera.width ||
      corner.y + 1 >= camera.height) {
    return false;
  }
  const uint8_t* above = &alpha[size_t(corner.y) * size_t(camera.width) + size_t(corner.x)];
  const uint8_t* below = above + camera.width;
  return above[0] == 0 && above[1] == 0 && below[0] == 0 && below[1] == 0;
}

Triangulation Filtered(const ColmapModel& model, const Scene& scene, const ViewAlphas& alphas) {
  Triangulation result;
  result.found = model.points.size();
  for (const auto& [id, point] : model.points) {
    if (point.track.size() < kMinTrack || point.error_px > kMaxPointError_px) {
      ++result.weak;
    } else if (IsSeenThrough(scene, alphas, point.position)) {
      ++result.transparent;
    } else {
      result.points.push_back(
          {point.position, point.color_srgb, float(point.error_px), uint32_t(point.track.size())});
    }
  }
  return result;
}

}  // namespace

bool IsSeenThrough(const Scene& scene, const ViewAlphas& alphas, const glm::dvec3& point) {
  for (size_t i = 0; i < scene.views.size(); ++i) {
    const View& view = scene.views[i];
    if (view.split == Split::kTrain &&
        SeesThrough(scene.cameras[size_t(view.camera)], view.cam_from_world, alphas[i], point)) {
      return true;
    }
  }
  return false;
}

Triangulation TriangulatePoints(const fs::path& folder, const Scene& scene,
                                const ViewAlphas& alphas, const ColmapPlace& place) {
  TETREC_CHECK(alphas.size() == scene.views.size(), "one alpha per view");
  const ColmapProgram colmap = FindColmap(place.log);
  const Photos photos = WritePhotos(folder, scene, place.scratch / "photos");
  LogInfo("COLMAP {}: points from {} images with known cameras", colmap.version,
          photos.names.size());
  const fs::path cache = place.cache / MatchesKey(photos, colmap);
  fs::create_directories(cache);
  const fs::path database = cache / "features.db";
  if (!fs::exists(database)) {
    ExtractFeatures(colmap, photos.folder, photos.names, {"PINHOLE", false, kMaxFeatures},
                    cache / "parts", database);
    fs::remove_all(cache / "parts");
  }
  const MatchCounts matches = MatchFeatures(colmap, database, PairChoice::kAuto, place.scratch);
  LogInfo("{} matches in {} pairs", WithThousands(matches.matches), WithThousands(matches.pairs));

  const fs::path known = place.scratch / "known", found = place.scratch / "triangulated";
  fs::remove_all(known);
  WriteColmapModel(known, KnownCameras(scene, photos));
  fs::remove_all(found);
  fs::create_directories(found);
  Triangulation result;
  if (TriangulateModel(colmap, photos.folder, database, known, found)) {
    const ColmapModel model = ReadColmapModel(found);
    CheckUnmoved(model, scene, photos, colmap);
    result = Filtered(model, scene, alphas);
  }
  LogInfo(
      "{} points triangulated, {} dropped as weak and {} because a view sees through them; {} kept",
      WithThousands(result.found), WithThousands(result.weak), WithThousands(result.transparent),
      WithThousands(result.points.size()));
  if (result.points.empty()) {
    throw DataError(fmt::format(
        "triangulation found no point that {} views share among {} images; they show too little "
        "texture, or their cameras are wrong; do without triangulation",
        kMinTrack, photos.names.size()));
  }
  return result;
}

}  // namespace tetrec
