// Which places many training photos look at. Many photos forbid fog by themselves and agree on what
// is solid; a few do not.
#pragma once

#include "geometry/camera.h"
#include "geometry/rigid3.h"
#include "scene/scene.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace tetrec {

class PhotoFrames {
 public:
  PhotoFrames() = default;
  explicit PhotoFrames(const Scene& scene);

  // Whether the place [world units] is in the frames of more than 12 training photos, hidden or
  // not.
  bool ManyShow(const glm::dvec3& place) const;
  std::vector<uint8_t> ManyShow(std::span<const glm::vec3> places) const;  // for each place

 private:
  struct Frame {
    Rigid3 cam_from_world;
    Camera camera;
  };
  std::vector<Frame> frames_;
};

}  // namespace tetrec
