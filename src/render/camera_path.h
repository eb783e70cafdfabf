// Paths of a camera: one pose per frame of a video.
#pragma once

#include "core/words.h"
#include "scene/scene.h"

#include <vector>

namespace tetrec {

enum class CameraPath {
  kNone,     // single views
  kOrbit,    // once around the subject
  kCameras,  // through the scene's cameras, in their order
};
template <>
inline constexpr auto kWords<CameraPath> =
    std::to_array<Word<CameraPath>>({{CameraPath::kNone, "none"},
                                     {CameraPath::kOrbit, "orbit"},
                                     {CameraPath::kCameras, "cameras"}});

// cam_from_world of each frame: a circle around the z axis through the subject's centre, at the
// median height and distance of the cameras of `views` (not empty), from the first camera's side.
// The last frame is one step before the first, so that the video may be repeated.
std::vector<Rigid3> OrbitPath(const Scene& scene, const std::vector<int>& views, size_t frames);

// cam_from_world of each frame: from the first to the last camera of `views` (two or more), at
// constant mean speed between cameras; centres on a cubic Hermite spline, whose tangents are the
// slopes of parabolas through three centres, rotations by spherical interpolation.
std::vector<Rigid3> PathThroughCameras(const Scene& scene, const std::vector<int>& views,
                                       size_t frames);

// The camera with the same field of view, its longer side `size` px (0: as it is), and both sides
// even, as common video formats require.
Camera VideoCamera(const Camera& camera, int size);

}  // namespace tetrec
