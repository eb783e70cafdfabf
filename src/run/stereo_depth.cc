// Writes, reads and checks depth maps.
#include "run/stereo_depth.h"

#include "core/error.h"
#include "core/file.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>

namespace tetrec {
namespace {

constexpr char kMagic[] = "TETRECD1";
constexpr uint32_t kMaxDepthMapSide_px = 1 << 16;

void CheckCamera(const Camera& camera, const std::string& name) {
  const bool has_size = camera.width > 0 && camera.height > 0 &&
                        uint32_t(camera.width) <= kMaxDepthMapSide_px &&
                        uint32_t(camera.height) <= kMaxDepthMapSide_px;
  const bool has_focus = camera.fx > 0 && camera.fy > 0 && std::isfinite(camera.fx) &&
                         std::isfinite(camera.fy) && std::isfinite(camera.cx) &&
                         std::isfinite(camera.cy);
  if (has_size && has_focus) return;
  throw DataError(fmt::format("{}: a camera of {} x {} pixels and focal lengths {} and {} px", name,
                              camera.width, camera.height, camera.fx, camera.fy));
}

void CheckPixels(const StereoDepth& map, const std::string& name) {
  const size_t pixels = size_t(map.camera.width) * size_t(map.camera.height);
  if (map.depth.size() != pixels || map.agreement.size() != pixels) {
    throw DataError(fmt::format("{}: {} depths and {} counts for {} pixels", name, map.depth.size(),
                                map.agreement.size(), pixels));
  }
  for (size_t i = 0; i < pixels; ++i) {
    if (!std::isfinite(map.depth[i]) || map.depth[i] < 0) {
      throw DataError(fmt::format("{}: the depth of pixel {} is {}", name, i, map.depth[i]));
    }
    if (map.depth[i] == 0 && map.agreement[i] != 0) {
      throw DataError(fmt::format("{}: pixel {} has no depth, but {} views confirm it", name, i,
                                  map.agreement[i]));
    }
  }
}

}  // namespace

StereoDepth MakeStereoDepth(uint32_t view, const Camera& camera) {
  const size_t pixels = size_t(camera.width) * size_t(camera.height);
  return {view, camera, std::vector<float>(pixels, 0.0f), std::vector<uint8_t>(pixels, 0)};
}

void WriteStereoDepth(const std::filesystem::path& path, const StereoDepth& map) {
  CheckCamera(map.camera, path.string());
  CheckPixels(map, path.string());
  const Camera& camera = map.camera;
  const uint32_t sizes[] = {map.view, uint32_t(camera.width), uint32_t(camera.height)};
  const double lens[] = {camera.fx, camera.fy, camera.cx, camera.cy};
  FileWriter file(path, 8 + sizeof(sizes) + sizeof(lens) + 5 * map.depth.size());
  file.WriteArray(std::span<const char>(kMagic, 8));
  file.WriteArray(std::span<const uint32_t>(sizes));
  file.WriteArray(std::span<const double>(lens));
  file.WriteArray(std::span<const float>(map.depth));
  file.WriteArray(std::span<const uint8_t>(map.agreement));
  file.Finish();
}

StereoDepth ReadStereoDepth(const std::filesystem::path& path) {
  return ParseStereoDepth(ReadBytes(path), path.string());
}

StereoDepth ParseStereoDepth(std::span<const uint8_t> bytes, const std::string& name) {
  ByteReader reader(bytes, name);
  char magic[8];
  reader.Copy(magic, 8, "the format's name");
  if (std::memcmp(magic, kMagic, 8) != 0) {
    throw DataError(fmt::format("{}: not a depth map of version 1", name));
  }
  StereoDepth map;
  map.view = reader.Read<uint32_t>("the view");
  const uint32_t width = reader.Read<uint32_t>("the width");
  const uint32_t height = reader.Read<uint32_t>("the height");
  if (width > kMaxDepthMapSide_px || height > kMaxDepthMapSide_px) {
    throw DataError(fmt::format("{}: {} x {} pixels; expected at most {} per side", name, width,
                                height, kMaxDepthMapSide_px));
  }
  map.camera.width = int(width);
  map.camera.height = int(height);
  for (double* value : {&map.camera.fx, &map.camera.fy, &map.camera.cx, &map.camera.cy}) {
    *value = reader.Read<double>("the camera");
  }
  CheckCamera(map.camera, name);
  const uint64_t pixels = uint64_t{width} * height;
  map.depth = reader.ReadArray<float>(pixels, "the depths");
  map.agreement = reader.ReadArray<uint8_t>(pixels, "the numbers of views");
  reader.ExpectEnd();
  CheckPixels(map, name);
  return map;
}

std::string StereoDepthName(uint32_t view) { return fmt::format("{:04}.depth", view); }

std::optional<StereoDepth> FindStereoDepth(const std::filesystem::path& start_folder,
                                           uint32_t view) {
  const std::filesystem::path path = start_folder / "depth" / StereoDepthName(view);
  if (!std::filesystem::exists(path)) return std::nullopt;
  StereoDepth map = ReadStereoDepth(path);
  if (map.view == view) return map;
  throw DataError(
      fmt::format("{}: is the depth map of view {}, not {}", path.string(), map.view, view));
}

}  // namespace tetrec
