// The training views of a scene without those that the fit left out, with the cameras that the fit
// ended with: from these, its field looks right.
#pragma once

#include "geometry/camera.h"
#include "geometry/rigid3.h"
#include "scene/scene.h"

#include <filesystem>
#include <string>
#include <vector>

namespace tetrec {

// What becomes of a stage that is stopped while it works on these views.
inline constexpr const char* kAfterASurfaceStop = "the surface will be extracted again";

struct TrainedView {
  uint32_t index = 0;  // into Scene::views
  std::string name;
  std::filesystem::path image;  // relative to the scene's folder
  Camera camera;
  Rigid3 cam_from_world;  // corrected by the run, if the field's folder has corrections
};

// Throws DataError for the files of corrections and of photos that were left out.
std::vector<TrainedView> TrainedViews(const Scene& scene,
                                      const std::filesystem::path& field_folder);

}  // namespace tetrec
