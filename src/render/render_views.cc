// Renders views of a finished field and stores the ground truth beside them.
#include "render/render_views.h"

#include "core/error.h"
#include "core/log.h"
#include "core/manifest.h"
#include "core/progress.h"
#include "core/short_list.h"
#include "core/stop_request.h"
#include "core/timer.h"
#include "geometry/small_motion.h"
#include "image/file_names.h"
#include "image/image.h"
#include "image/normal_map.h"
#include "render/buried_cameras.h"
#include "render/create_renderer.h"
#include "render/kernel_table.h"
#include "render/picture.h"
#include "render/target_image.h"
#include "render/view_pose.h"
#include "run/camera_corrections.h"
#include "run/rendered_views.h"
#include "scene/scene.h"

#include <fmt/format.h>

#include <numeric>

namespace tetrec {
namespace {

namespace fs = std::filesystem;

// One file for each view of the scene, the same whichever of them are rendered.
std::vector<std::string> FileNamesOf(const Scene& scene) {
  std::vector<std::string> names;
  for (const View& view : scene.views) names.push_back(view.name);
  return PngFiles(names, Folders::kFlatten);
}

bool ShowsAnythingSeen(const Image& rgba) {
  for (size_t i = 3; i < rgba.pixels.size(); i += 4) {
    if (rgba.pixels[i] >= kSeenAlpha) return true;
  }
  return false;
}

// Lost rays are counted whichever renderer is used.
RendererOptions CheckingRays(RendererOptions options) {
  options.count_steps |= !ChecksRays(options);
  return options;
}

void WarnOfBuriedCameras(const RadianceField& field, const Scene& scene, Stage& stage) {
  const std::vector<std::string> buried = BuriedCameras(field, scene);
  stage.Note("buried_cameras", buried);
  if (buried.empty()) return;
  LogWarning(
      "{} of {} cameras stand inside of opaque density, which hides what they should show: {}; "
      "more photos from places near them would keep the space around them free",
      buried.size(), scene.views.size(), ShortList(buried));
}

bool RefinesCameras(RefineCameras choice, const fs::path& field_folder) {
  if (choice == RefineCameras::kAuto) return fs::exists(field_folder / kCameraCorrectionsFile);
  return choice == RefineCameras::kOn;
}

// A held-out camera may be as wrong as a training camera was, and nothing has corrected it yet.
constexpr PoseFitOptions kRefinement{.pixels = 4096, .iterations = 6};

// Where a view's camera fits its true image best, with the field as it is.
PoseFit RefineCamera(Renderer& renderer, const RenderView& view, const TargetImage& target,
                     Background background) {
  const PoseTask task{view, view.cam_from_world, target, std::nullopt, BackgroundColor(background)};
  return FitPose(renderer, task, kRefinement);
}

double ShiftOf(const RenderView& view, const PoseFit& fit) {
  if (!fit.is_better) return 0;
  return PictureShift(view.camera, fit.cam_from_world * view.cam_from_world.Inverse(), fit.depth);
}

// Renders the view from its refined camera, and completes the entry.
void RenderRefined(Renderer& renderer, const RenderViewsOptions& options, const RenderView& view,
                   const TargetImage& target, Background background, const fs::path& file,
                   RenderedView& entry) {
  const PoseFit fit = RefineCamera(renderer, view, target, background);
  const RenderView refined{view.camera, fit.cam_from_world};
  WriteImage(file, ToPicture(renderer.Render(refined, options.samples), background));
  entry.refined = file;
  entry.refined_shift_px = ShiftOf(view, fit);
}

}  // namespace

std::vector<int> ChooseViews(const Scene& scene, const std::string& choice) {
  if (choice == "train") return scene.ViewsOf(Split::kTrain);
  if (choice == "heldout") return scene.HeldOutViews();
  std::vector<int> all(scene.views.size());
  std::iota(all.begin(), all.end(), 0);
  return all;
}

Background ChooseBackground(const Scene& scene, const std::string& choice) {
  if (choice == "white") return Background::kWhite;
  return choice == "black" ? Background::kBlack : scene.background;
}

RendererOptions RendererFor(const TetMesh& mesh, const RendererOptions& options, Stage& stage) {
  RendererOptions result = CheckingRays(options);
  const uint64_t degenerate = CountDegenerateTets(mesh);
  stage.Count("degenerate_tets", degenerate);
  if (degenerate == 0) return result;
  LogWarning("{} of {} tets are inside out or flat: the images show parts of space twice or not",
             WithThousands(degenerate), WithThousands(mesh.tets.size()));
  result.AcceptInvertedTets();
  return result;
}

void RunRenderViews(const RenderViewsOptions& options, Stage& stage) {
  const fs::path field_folder = stage.Input("FIELD");
  const fs::path scene_folder = PreviousStage(field_folder, {"sfm", "import"});
  const Scene scene = ReadScene(scene_folder);
  const RadianceField field = ReadField(field_folder / "field.tetf", Orientations::kAny);
  const Background background = ChooseBackground(scene, options.background);
  std::string choice = options.views;
  if (choice == "heldout" && scene.HeldOutViews().empty()) {
    LogWarning(
        "no view is held out: the training views are rendered, and scores are of what was "
        "learned");
    choice = "train";
  }
  const std::vector<int> views = ChooseViews(scene, choice);
  if (views.empty()) {
    throw DataError(fmt::format("{}: the scene has no {} views; choose all views",
                                scene_folder.string(), choice));
  }
  const std::unique_ptr<TrainingRenderer> renderer =
      CreateRenderer(RendererFor(field.mesh, options.renderer, stage));
  stage.Device(renderer->DescribeDevice());
  WarnOfBuriedCameras(field, scene, stage);
  renderer->SetField(field);
  for (const char* folder : {"renders", "depth", "normals", "gt"})
    fs::create_directories(stage.Output(folder));
  // Masks select the subject, or the pixels that count.
  const std::string mask_folder = scene.has_masks ? "seen" : "masks";
  if (scene.has_alpha || scene.has_masks) fs::create_directories(stage.Output(mask_folder));
  const bool refines = RefinesCameras(options.refine_cameras, field_folder);
  if (refines) fs::create_directories(stage.Output("refined"));

  const Timer timer;
  double render_seconds = 0;
  Progress progress("render", double(views.size()));
  const std::vector<std::string> files = FileNamesOf(scene);
  RenderedViews result;
  for (size_t i = 0; i < views.size(); ++i) {
    ThrowIfStopRequested("images rendered so far will be rendered again");
    const View& view = scene.views[views[i]];
    const Timer render_timer;
    const RenderView seen_from{scene.cameras[size_t(view.camera)], view.cam_from_world};
    const RenderedImage rendered = renderer->Render(seen_from, options.samples);
    const DepthMap depth = renderer->RenderDepth(seen_from, kHalfLightDepth);
    render_seconds += render_timer.seconds();
    const std::string& file = files[views[i]];
    const Image truth = ReadImage(scene_folder / view.image);
    const bool has_mask = truth.channels == 4;
    if (scene.has_masks && has_mask && !ShowsAnythingSeen(truth)) {
      LogWarning("{}: its mask hides all pixels; the view is left out", view.name);
      continue;
    }
    RenderedView entry{view.name,
                       Name(view.split),
                       stage.folder() / "renders" / file,
                       stage.folder() / "gt" / file,
                       {},
                       {},
                       (stage.folder() / "depth" / file).replace_extension(".exr"),
                       (stage.folder() / "normals" / file).replace_extension(".exr"),
                       {},
                       {}};
    WriteDepthMap(*entry.depth, depth);
    WriteNormalMap(*entry.normals, Rotated(glm::transpose(view.cam_from_world.rotation),
                                           NormalsOf(depth, seen_from.camera)));
    WriteImage(entry.render, ToPicture(rendered, background));
    WriteImage(entry.truth, TruthOf(truth, scene.has_masks, background));
    if (has_mask) {
      const fs::path mask = stage.folder() / mask_folder / file;
      WriteImage(mask, MaskOf(truth));
      (scene.has_masks ? entry.seen : entry.mask) = mask;
    }
    if (refines) {
      RenderRefined(*renderer, options, seen_from, TargetOf(truth, scene.has_masks), background,
                    stage.folder() / "refined" / file, entry);
    }
    result.views.push_back(std::move(entry));
    progress.Update(double(i + 1), view.name);
  }
  const Camera& camera = scene.cameras[scene.views[views[0]].camera];
  result.background = Name(background);
  result.split = choice == "heldout" ? Name(scene.views[views[0]].split) : choice;
  result.rays_per_pixel = options.samples * options.samples;
  result.width = camera.width;
  result.height = camera.height;
  WriteRenderedViews(stage.Output(kRenderedViewsFile), result);
  const RenderCounts counts = renderer->counts();
  stage.Count("views", result.views.size());
  stage.Count("hidden_views", views.size() - result.views.size());
  stage.Count("rays", counts.rays);
  stage.Count("lost_rays", counts.lost_rays);
  stage.Seconds("render", render_seconds);
  LogInfo("{} images, {} rays, {} lost; {:.1f} s on the device, {:.1f} s in total",
          result.views.size(), WithThousands(counts.rays), counts.lost_rays, render_seconds,
          timer.seconds());
  LogKernelTimes(options.renderer, *renderer);
}

}  // namespace tetrec
