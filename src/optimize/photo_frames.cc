// Which places many training photos look at.
#include "optimize/photo_frames.h"

#include "core/parallel.h"

#include <cstddef>

namespace tetrec {
namespace {

constexpr int kFewPhotos = 12;

}  // namespace

PhotoFrames::PhotoFrames(const Scene& scene) {
  for (const int v : scene.ViewsOf(Split::kTrain)) {
    const View& view = scene.views[size_t(v)];
    frames_.push_back({view.cam_from_world, scene.cameras[size_t(view.camera)]});
  }
}

bool PhotoFrames::ManyShow(const glm::dvec3& place) const {
  int photos = 0;
  for (const Frame& frame : frames_) {
    if (frame.camera.Shows(frame.cam_from_world * place) && ++photos > kFewPhotos) return true;
  }
  return false;
}

std::vector<uint8_t> PhotoFrames::ManyShow(std::span<const glm::vec3> places) const {
  std::vector<uint8_t> result(places.size(), 0);
  ParallelFor(places.size(), 256, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) result[i] = uint8_t(ManyShow(glm::dvec3(places[i])));
  });
  return result;
}

}  // namespace tetrec
