// Depth maps of training views, which the start writes and later stages may read.
//
// A .depth file, little endian: "TETRECD1", u32 index of the view in the scene, u32 width, u32
// height, f64 fx, fy, cx, cy [px of the map], f32 depth x width x height, u8 agreeing views x width
// x height.
#pragma once

#include "geometry/camera.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tetrec {

struct StereoDepth {
  uint32_t view = 0;               // index into Scene::views
  Camera camera;                   // of the map, whose resolution may differ from the image's
  std::vector<float> depth;        // height x width: z in the camera frame [world units]; 0: none
  std::vector<uint8_t> agreement;  // height x width: how many other views confirm the depth

  size_t Index(int x, int y) const { return size_t(y) * size_t(camera.width) + size_t(x); }
};

// So many other views must confirm a depth that is relied on: a wrong one may keep empty what is
// full, which learning cannot mend.
inline constexpr uint8_t kLeastAgreement = 2;

// A map without depths.
StereoDepth MakeStereoDepth(uint32_t view, const Camera& camera);

// Throw DataError naming the file and what is wrong: sizes that do not fit the file, a camera that
// is none, a depth that is negative or not finite, agreement without depth.
void WriteStereoDepth(const std::filesystem::path& path, const StereoDepth& map);
StereoDepth ReadStereoDepth(const std::filesystem::path& path);
StereoDepth ParseStereoDepth(std::span<const uint8_t> bytes, const std::string& name);

// The file of a view below the folder of the depth maps: "0007.depth".
std::string StereoDepthName(uint32_t view);

// The depth map of a view that tetrec-tetrahedralize --start dense wrote below `start_folder`, if
// there is one. Throws DataError, naming the file, if it is that of another view.
std::optional<StereoDepth> FindStereoDepth(const std::filesystem::path& start_folder,
                                           uint32_t view);

}  // namespace tetrec
