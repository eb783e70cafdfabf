// What the training photos see of a place, by their frames and by the depth maps of a dense start.
#pragma once

#include "geometry/camera.h"
#include "geometry/rigid3.h"
#include "run/stereo_depth.h"
#include "scene/scene.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace tetrec {

// Many photos forbid fog by themselves and agree on what is solid; a few do not.
struct PlaceSight {
  bool is_of_many = false;  // more than 12 photos see the place
  bool is_empty = false;    // no more see it, and it is known to be empty
  bool is_surface = false;  // depth maps agree on a surface there
  bool operator==(const PlaceSight&) const = default;
};

// A photo sees a place that is in its frame, unless its depth map shows only what is in front of
// the place. A place that few photos see is empty if at least 2 maps show something clearly behind
// it and none shows something near it. A place is at a surface if at least 3 maps, or 2 of a
// small collection, show one right there, and at most a fifth as many show something behind. Only
// depths that at least 2 other views confirm count.
class PhotoSight {
 public:
  // No photo sees anything.
  PhotoSight() = default;
  // `scene` has the training cameras. `maps`: of some of the training views, or of none.
  explicit PhotoSight(const Scene& scene, std::span<const StereoDepth> maps = {});

  std::vector<PlaceSight> Of(std::span<const glm::vec3> places) const;  // [world units]

  // The centres of the cameras whose photos see the place.
  std::vector<glm::dvec3> CentersThatSee(const glm::dvec3& place) const;
  // The centres of all cameras.
  std::vector<glm::dvec3> Centers() const;

  // At most 20 photos, which haze explains as well as walls.
  bool IsOfSmallCollection() const;

  // Reads the depth maps that tetrec-tetrahedralize --start dense wrote below `start_folder`, if
  // there are any. Throws DataError, naming the file, for a map that does not fit the scene.
  static PhotoSight Read(const Scene& scene, const std::filesystem::path& start_folder);

 private:
  // A smaller map: a confirmed depth in each block, or 0, height x width, z in the camera frame
  // [world units].
  struct Blocks {
    Camera camera;
    std::vector<float> depth;

    float DepthAt(const glm::dvec3& in_cam) const;  // 0 beside the map, too
  };
  struct Photo {
    uint32_t view = 0;  // index into Scene::views
    Rigid3 cam_from_world;
    Camera camera;
    Blocks least, largest;  // of its depth map; without one, empty

    void Summarize(const StereoDepth& map);
    bool Sees(const glm::dvec3& in_cam) const;
  };
  PlaceSight Of(const glm::dvec3& place) const;

  std::vector<Photo> photos_;
  bool has_maps_ = false;
};

}  // namespace tetrec
