// Pictures of a finished field, beside the ground truth.
#include "render/render_views.h"

#include "core/error.h"
#include "core/file.h"
#include "core/log.h"
#include "core/progress.h"
#include "render/kernel_table.h"
#include "render/picture.h"
#include "scene/image.h"
#include "scene/scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

namespace tetrec {
namespace {

namespace fs = std::filesystem;

std::vector<int> ChooseViews(const Scene& scene, const std::string& choice) {
  if (choice == "train") return scene.ViewsOf(Split::kTrain);
  if (choice == "heldout") return scene.HeldOutViews();
  std::vector<int> all(scene.views.size());
  std::iota(all.begin(), all.end(), 0);
  return all;
}

// "test/r_0.png" becomes "test_r_0".
std::string FlatName(std::string name) {
  std::replace(name.begin(), name.end(), '/', '_');
  const size_t dot = name.rfind('.');
  return dot == std::string::npos ? name : name.substr(0, dot);
}

Image MaskOf(const Image& rgba) {
  Image mask{rgba.width, rgba.height, 3, {}};
  for (size_t i = 0; i < rgba.pixels.size(); i += 4) {
    mask.pixels.insert(mask.pixels.end(), 3, rgba.pixels[i + 3]);
  }
  return mask;
}

bool ShowsAnythingSeen(const Image& rgba) {
  for (size_t i = 3; i < rgba.pixels.size(); i += 4) {
    if (rgba.pixels[i] >= kSeenAlpha) return true;
  }
  return false;
}

// Pictures tell of lost rays, whatever renders them.
RendererOptions CheckingRays(RendererOptions options) {
  options.count_steps |= !ChecksRays(options);
  return options;
}

}  // namespace

void RunRenderViews(const RenderViewsOptions& options, Stage& stage) {
  const fs::path field_folder = stage.Input("FIELD");
  const fs::path scene_folder = PreviousStage(field_folder, {"sfm", "import"});
  const Scene scene = ReadScene(scene_folder);
  const RadianceField field = ReadField(field_folder / "field.tetf");
  const Background background = options.background == "white"   ? Background::kWhite
                                : options.background == "black" ? Background::kBlack
                                                                : scene.background;
  const std::vector<int> views = ChooseViews(scene, options.views);
  if (views.empty()) {
    throw DataError(fmt::format("{}: the scene has no {} views; use --views all",
                                scene_folder.string(), options.views));
  }
  const std::unique_ptr<TrainingRenderer> renderer = CreateRenderer(CheckingRays(options.renderer));
  stage.Device(renderer->DescribeDevice());
  renderer->SetField(field);
  for (const char* folder : {"renders", "gt"}) fs::create_directories(stage.Output(folder));
  // What is on the subject, or what is to be judged.
  const std::string mask_folder = scene.has_masks ? "seen" : "masks";
  if (scene.has_alpha || scene.has_masks) fs::create_directories(stage.Output(mask_folder));

  const Timer timer;
  double render_seconds = 0;
  Progress progress("render", double(views.size()));
  nlohmann::json list = nlohmann::json::array();
  for (size_t i = 0; i < views.size(); ++i) {
    ThrowIfStopRequested("pictures rendered so far are made again");
    const View& view = scene.views[views[i]];
    const Timer render_timer;
    const RenderedImage rendered =
        renderer->Render({scene.cameras[view.camera], view.cam_from_world}, options.samples);
    render_seconds += render_timer.seconds();
    const std::string file = FlatName(view.name) + ".png";
    const Image truth = ReadImage(scene_folder / view.image);
    const bool has_mask = truth.channels == 4;
    if (scene.has_masks && has_mask && !ShowsAnythingSeen(truth)) {
      LogWarning("{}: its mask leaves nothing to judge; it is left out", view.name);
      continue;
    }
    WriteImage(stage.folder() / "renders" / file, ToPicture(rendered, background));
    WriteImage(stage.folder() / "gt" / file, OverBackground(truth, background));
    if (has_mask) WriteImage(stage.folder() / mask_folder / file, MaskOf(truth));
    list.push_back(
        {{"name", view.name},
         {"split", Name(view.split)},
         {"render", "renders/" + file},
         {"ground_truth", "gt/" + file},
         {scene.has_masks ? "seen" : "mask",
          has_mask ? nlohmann::json(mask_folder + "/" + file) : nlohmann::json(nullptr)}});
    progress.Update(double(i + 1), view.name);
  }
  const Camera& camera = scene.cameras[scene.views[views[0]].camera];
  WriteJson(stage.Output("views.json"),
            {{"schema", 1},
             {"background", Name(background)},
             {"rays_per_pixel", options.samples * options.samples},
             {"split", options.views == "heldout" ? Name(scene.views[views[0]].split)
                                                  : options.views.c_str()},
             {"resolution", {camera.width, camera.height}},
             {"views", list}});
  const RenderCounts counts = renderer->counts();
  stage.Count("views", views.size());
  stage.Count("rays", counts.rays);
  stage.Count("lost_rays", counts.lost_rays);
  stage.Seconds("render", render_seconds);
  LogInfo("{} pictures, {} rays, {} lost; {:.1f} s on the device, {:.1f} s in all", views.size(),
          WithThousands(counts.rays), counts.lost_rays, render_seconds, timer.seconds());
  LogKernelTimes(options.renderer, *renderer);
}

}  // namespace tetrec
