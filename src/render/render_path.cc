// Frames of a path, and the video of them.
#include "render/render_path.h"

#include "core/child_process.h"
#include "core/error.h"
#include "core/log.h"
#include "core/manifest.h"
#include "core/option_range.h"
#include "core/progress.h"
#include "core/stop_request.h"
#include "core/timer.h"
#include "image/image.h"
#include "render/create_renderer.h"
#include "render/picture.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

namespace tetrec {
namespace {

namespace fs = std::filesystem;

constexpr int kMostFrames = 100'000, kLargestSide_px = 8192;

fs::path FindFfmpeg() {
  const fs::path ffmpeg = FindProgram("ffmpeg");
  if (ffmpeg.empty()) {
    throw EnvironmentError(
        "ffmpeg, which writes videos, is not in PATH; install it: "
        "apt-get install --no-install-recommends ffmpeg");
  }
  return ffmpeg;
}

// Makes video.mp4 of the frames 000000.png, 000001.png and so on in `folder`. Names are relative to
// the folder, because ffmpeg finds patterns and protocols in paths. The file names its colour
// matrix: players guess another one otherwise, by the size of the pictures.
void EncodeVideo(const fs::path& ffmpeg, const fs::path& folder, double fps) {
  ChildOptions options;
  options.working_folder = folder;
  const ChildResult result = RunChild(ffmpeg,
                                      {"-nostdin",
                                       "-hide_banner",
                                       "-loglevel",
                                       "error",
                                       "-framerate",
                                       fmt::format("{}", fps),
                                       "-i",
                                       "%06d.png",
                                       "-vf",
                                       "scale=out_color_matrix=bt709:out_range=tv",
                                       "-c:v",
                                       "libx264",
                                       "-crf",
                                       "18",
                                       "-pix_fmt",
                                       "yuv420p",
                                       "-colorspace",
                                       "bt709",
                                       "-color_primaries",
                                       "bt709",
                                       "-color_trc",
                                       "iec61966-2-1",
                                       "-color_range",
                                       "tv",
                                       "-movflags",
                                       "+faststart",
                                       "-y",
                                       "video.mp4"},
                                      options);
  if (result.exit_code != 0) {
    throw EnvironmentError(fmt::format("ffmpeg ended with exit code {}: {}", result.exit_code,
                                       fmt::join(result.last_lines, " | ")));
  }
}

std::vector<Rigid3> PathOf(const RenderPathOptions& options, const RenderViewsOptions& views,
                           const Scene& scene, const fs::path& scene_folder) {
  if (options.path == CameraPath::kOrbit) {
    return OrbitPath(scene, ChooseViews(scene, "all"), options.FrameCount());
  }
  const std::vector<int> chosen = ChooseViews(scene, views.views);
  if (chosen.size() < 2) {
    throw DataError(
        fmt::format("{}: the scene has {} {} views, and a path through cameras needs 2 or more; "
                    "choose others with --views",
                    scene_folder.string(), chosen.size(), views.views));
  }
  return PathThroughCameras(scene, chosen, options.FrameCount());
}

// The camera of most views: portrait and landscape photos have different ones.
const Camera& UsualCamera(const Scene& scene) {
  std::vector<size_t> views(scene.cameras.size(), 0);
  for (const View& view : scene.views) ++views[size_t(view.camera)];
  return scene.cameras[size_t(std::ranges::max_element(views) - views.begin())];
}

}  // namespace

size_t RenderPathOptions::FrameCount() const {
  return frames > 0 ? size_t(frames) : size_t(std::max(1.0, std::round(seconds * fps)));
}

void RenderPathOptions::Check() const {
  CheckRange("fps", fps, 1.0, 240.0);
  CheckRange("frames", frames, 0, kMostFrames);
  CheckRange("size", size, 0, kLargestSide_px);
  CheckAboveZero("seconds", seconds);
  if (!(seconds * fps <= kMostFrames)) {
    throw UsageError(fmt::format("seconds is {}, which are more than {} frames at {} per second",
                                 seconds, kMostFrames, fps));
  }
}

void RunRenderPath(const RenderPathOptions& options, const RenderViewsOptions& views,
                   Stage& stage) {
  const fs::path ffmpeg = FindFfmpeg();
  const fs::path field_folder = stage.Input("FIELD");
  const fs::path scene_folder = PreviousStage(field_folder, {"sfm", "import"});
  const Scene scene = ReadScene(scene_folder);
  const std::vector<Rigid3> path = PathOf(options, views, scene, scene_folder);
  const Camera camera = VideoCamera(UsualCamera(scene), options.size);
  const Background background = ChooseBackground(scene, views.background);
  const RadianceField field = ReadField(field_folder / "field.tetf", Orientations::kAny);
  const std::unique_ptr<TrainingRenderer> renderer =
      CreateRenderer(RendererFor(field.mesh, views.renderer, stage));
  stage.Device(renderer->DescribeDevice());
  renderer->SetField(field);

  const fs::path frames = stage.Scratch("frames");
  fs::create_directories(frames);
  const Timer timer;
  Progress progress("render", double(path.size()));
  for (size_t i = 0; i < path.size(); ++i) {
    ThrowIfStopRequested("frames rendered so far will be rendered again");
    const RenderedImage rendered = renderer->Render({camera, path[i]}, views.samples);
    WriteImage(frames / fmt::format("{:06}.png", i), ToPicture(rendered, background));
    progress.Update(double(i + 1), fmt::format("frame {}/{}", i + 1, path.size()));
  }
  stage.Seconds("render", timer.seconds());
  EncodeVideo(ffmpeg, frames, options.fps);
  fs::rename(frames / "video.mp4", stage.Output("video.mp4"));
  stage.Count("frames", path.size());
  stage.Count("lost_rays", renderer->counts().lost_rays);
  LogInfo("{} frames of {}x{} px, {:.3g} s at {:.4g} per second: {}", path.size(), camera.width,
          camera.height, double(path.size()) / options.fps, options.fps,
          (stage.folder() / "video.mp4").string());
}

}  // namespace tetrec
