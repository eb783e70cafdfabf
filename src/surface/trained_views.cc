// The training views of a scene from the cameras that a fit left.
#include "surface/trained_views.h"

#include "run/camera_corrections.h"

#include <map>

namespace tetrec {

std::vector<TrainedView> TrainedViews(const Scene& scene,
                                      const std::filesystem::path& field_folder) {
  std::map<std::string, Rigid3> corrected;
  const std::filesystem::path file = field_folder / kCameraCorrectionsFile;
  if (std::filesystem::exists(file)) {
    for (const CameraCorrection& c : ReadCameraCorrections(file)) {
      corrected.emplace(c.name, c.cam_from_world);
    }
  }
  std::vector<TrainedView> views;
  for (const int v : scene.ViewsOf(Split::kTrain)) {
    const View& view = scene.views[size_t(v)];
    const auto found = corrected.find(view.name);
    views.push_back({view.name, view.image, scene.cameras[size_t(view.camera)],
                     found == corrected.end() ? view.cam_from_world : found->second});
  }
  return views;
}

}  // namespace tetrec
