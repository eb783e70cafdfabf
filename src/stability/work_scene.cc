// Reads, makes and writes scenes for the stability test.
#include "stability/work_scene.h"

#include "core/file.h"
#include "core/manifest.h"
#include "core/stage_input.h"
#include "core/stage_run.h"

namespace tetrec {
namespace fs = std::filesystem;
namespace {

// Stands for the pictures and the rest of the scene in the key, so that a folder of other content
// is not taken for up to date.
std::string HashOf(const SceneWithImages& given) {
  nlohmann::json parts = nlohmann::json::array();
  for (const Image& image : given.images) parts.push_back(Sha256(image.pixels));
  for (const View& view : given.scene.views) {
    const Rigid3& pose = view.cam_from_world;
    for (int i = 0; i < 3; ++i) {
      parts.push_back(pose.translation[i]);
      for (int k = 0; k < 3; ++k) parts.push_back(pose.rotation[i][k]);
    }
    parts.push_back(view.name);
  }
  for (const ScenePoint& point : given.scene.points) {
    for (int i = 0; i < 3; ++i) parts.push_back(point.position[i]);
  }
  return HashOfJson(parts);
}

}  // namespace

SceneWithImages SyntheticRoom(bool is_short, uint64_t seed) {
  const int side = is_short ? 32 : 64;
  return MakeSyntheticScene({.kind = SyntheticKind::kRoom,
                             .train_views = is_short ? 16 : 24,
                             .validation_views = 0,
                             .test_views = is_short ? 4 : 6,
                             .width = side,
                             .height = side,
                             .points = 1500,
                             .seed = seed});
}

SceneWithImages SyntheticBalls(bool is_short, uint64_t seed) {
  const int side = is_short ? 32 : 64;
  return MakeSyntheticScene({.kind = SyntheticKind::kTwoBalls,
                             .train_views = is_short ? 16 : 40,
                             .validation_views = 2,
                             .test_views = 4,
                             .width = side,
                             .height = side,
                             .seed = seed});
}

SceneWithImages ReadSceneWithImages(const fs::path& folder) {
  FirstStageOf(folder);
  SceneWithImages given{ReadScene(folder), {}};
  for (const View& view : given.scene.views) given.images.push_back(ReadImage(folder / view.image));
  return given;
}

std::string FirstStageOf(const fs::path& folder) {
  return ReadManifest(folder, {"sfm", "import"})["stage"];
}

void WriteSceneStage(const SceneWithImages& given, const std::string& stage,
                     const std::string& damage, const fs::path& folder) {
  const nlohmann::json options = {{"damage", damage}, {"content", HashOf(given)}};
  const StageRequest request = {.stage = stage,
                                .folder = folder,
                                .options = options,
                                .options_with_effect = options,
                                .command_line = "tetrec-stability"};
  RunStage(request, [&](Stage& running) {
    running.Output("images");
    running.Output("scene.json");
    if (!given.scene.points.empty()) running.Output("points.ply");
    WriteSyntheticScene(running.folder(), given);
  });
}

}  // namespace tetrec
