// Where the rays of the training cameras are stopped in a field.
#include "surface/seen_depths.h"

#include "core/progress.h"
#include "core/stop_request.h"
#include "mesh/tet_mesh.h"
#include "render/create_renderer.h"
#include "run/camera_corrections.h"
#include "scene/scene.h"

#include <map>
#include <memory>
#include <string>

namespace tetrec {
namespace {
namespace fs = std::filesystem;

// The optical depth of the surface. At half of the light, 0.69, the demo's surface lies 0.17 % of
// its diagonal too deep in the median, because the colour of what lies behind a soft surface is the
// same; at 0.35 its table, which many rays meet at a flat angle, lies too high.
constexpr double kSurfaceDepth = 0.4;

std::map<std::string, Rigid3> CorrectedCameras(const fs::path& field_folder) {
  std::map<std::string, Rigid3> cameras;
  const fs::path file = field_folder / kCameraCorrectionsFile;
  if (!fs::exists(file)) return cameras;
  for (const CameraCorrection& c : ReadCameraCorrections(file)) {
    cameras.emplace(c.name, c.cam_from_world);
  }
  return cameras;
}

}  // namespace

std::vector<SeenDepth> RenderSeenDepths(const RadianceField& field, const fs::path& scene_folder,
                                        const fs::path& field_folder, const DeviceOptions& device) {
  const Scene scene = ReadScene(scene_folder);
  const std::map<std::string, Rigid3> corrected = CorrectedCameras(field_folder);
  RendererOptions options;
  options.device = device;
  if (CountDegenerateTets(field.mesh) > 0) options.AcceptInvertedTets();
  const std::unique_ptr<TrainingRenderer> renderer = CreateRenderer(options);
  renderer->SetField(field);
  const std::vector<int> views = scene.ViewsOf(Split::kTrain);
  Progress progress("depth", double(views.size()));
  std::vector<SeenDepth> seen;
  for (const int v : views) {
    ThrowIfStopRequested("the surface will be extracted again");
    const View& view = scene.views[size_t(v)];
    const Camera& camera = scene.cameras[size_t(view.camera)];
    const auto found = corrected.find(view.name);
    const Rigid3 pose = found == corrected.end() ? view.cam_from_world : found->second;
    seen.push_back({camera, pose, renderer->RenderDepth({camera, pose}, kSurfaceDepth)});
    progress.Update(double(seen.size()), view.name);
  }
  return seen;
}

}  // namespace tetrec
