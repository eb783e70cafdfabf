// Space that photos show to be empty: in front of the surfaces on which their depth maps agree.
// Many photos forbid fog there by themselves; a few do not.
#pragma once

#include "geometry/camera.h"
#include "geometry/rigid3.h"
#include "optimize/photo_frames.h"
#include "run/stereo_depth.h"
#include "scene/scene.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace tetrec {

// A place is empty if at least 2 depth maps show something clearly behind it, none shows something
// near it, and not many photos have it in their frame (PhotoFrames). Only depths that at least 2
// other views confirm count.
class SeenSpace {
 public:
  // Nothing is known to be empty.
  SeenSpace() = default;
  // `scene` has the training cameras.
  SeenSpace(const Scene& scene, std::span<const StereoDepth> maps);

  // For each point whether it is known to be empty [world units].
  std::vector<uint8_t> Contains(std::span<const glm::vec3> points) const;
  bool empty() const { return maps_.empty(); }

  // Reads the depth maps that tetrec-tetrahedralize --start dense wrote below `start_folder`.
  // Without them nothing is known to be empty. Throws DataError, naming the file, for a map that
  // does not fit the scene.
  static SeenSpace Read(const Scene& scene, const std::filesystem::path& start_folder);

 private:
  // The least depth that two other views confirm, in each block of a map.
  struct LeastDepths {
    Rigid3 cam_from_world;
    Camera camera;             // of the blocks
    std::vector<float> depth;  // height x width: z in the camera frame [world units]; 0: unknown
  };
  static LeastDepths LeastDepthsOf(const Scene& scene, const StereoDepth& map);
  bool Contains(const glm::dvec3& point) const;

  PhotoFrames frames_;
  std::vector<LeastDepths> maps_;
};

}  // namespace tetrec
