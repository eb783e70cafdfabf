// The training views of a scene from the cameras that a fit left.
#include "surface/trained_views.h"

#include "core/error.h"
#include "run/camera_corrections.h"
#include "run/left_out_photos.h"

#include <fmt/format.h>

#include <map>
#include <set>

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
  std::set<std::string> left_out;
  if (const std::filesystem::path list = field_folder / kLeftOutPhotosFile;
      std::filesystem::exists(list)) {
    for (std::string& name : ReadLeftOutPhotos(list)) left_out.insert(std::move(name));
  }
  std::vector<TrainedView> views;
  for (const int v : scene.ViewsOf(Split::kTrain)) {
    const View& view = scene.views[size_t(v)];
    if (left_out.contains(view.name)) continue;
    const auto found = corrected.find(view.name);
    views.push_back({uint32_t(v), view.name, view.image, scene.cameras[size_t(view.camera)],
                     found == corrected.end() ? view.cam_from_world : found->second});
  }
  if (views.empty()) {
    throw DataError(fmt::format("{}: names all training views; run tetrec-optimize again",
                                (field_folder / kLeftOutPhotosFile).string()));
  }
  return views;
}

}  // namespace tetrec
