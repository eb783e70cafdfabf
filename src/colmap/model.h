// COLMAP's sparse models, and a reader of cameras.bin, images.bin and points3D.bin that checks what
// it reads (COLMAP's own trusts its input). Format: COLMAP documentation, "Output Format".
#pragma once

#include "geometry/lens.h"
#include "geometry/rigid3.h"

#include <glm/glm.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace tetrec {

constexpr uint64_t kNoColmapPoint = ~uint64_t{0};

struct ColmapObservation {
  glm::dvec2 pixel{0.0};
  uint64_t point = kNoColmapPoint;
};

struct ColmapImage {
  std::string name;
  uint32_t camera = 0;
  Rigid3 cam_from_world;
  std::vector<ColmapObservation> observations;
};

struct ColmapTrackItem {
  uint32_t image = 0, observation = 0;
};

struct ColmapPoint {
  glm::dvec3 position{0.0};
  std::array<uint8_t, 3> color_srgb{0, 0, 0};
  double error_px = 0;  // mean reprojection error
  std::vector<ColmapTrackItem> track;
};

struct ColmapModel {
  std::map<uint32_t, Lens> cameras;
  std::map<uint32_t, ColmapImage> images;
  std::map<uint64_t, ColmapPoint> points;
};

// Each part by itself, with checks of sizes, counts, finite numbers, unique ids and known camera
// models. Throws DataError, which names the file and the byte.
std::map<uint32_t, Lens> ParseColmapCameras(std::span<const uint8_t> bytes,
                                            const std::string& name);
std::map<uint32_t, ColmapImage> ParseColmapImages(std::span<const uint8_t> bytes,
                                                  const std::string& name);
std::map<uint64_t, ColmapPoint> ParseColmapPoints(std::span<const uint8_t> bytes,
                                                  const std::string& name);

// Checks that the parts fit each other: images have unique names and refer to cameras whose lenses
// are known, tracks and observations refer to each other. Throws DataError("<name>: ...").
void CheckColmapModel(const ColmapModel& model, const std::string& name);

// Removes what does not exist from observations and tracks, as in models from which scripts removed
// points or images. Returns the number of references removed.
size_t DropDanglingReferences(ColmapModel& model);

// What to do about references to points, images and observations that do not exist. kDrop: they are
// dropped, with a warning that counts them.
enum class DanglingReferences { kRefuse, kDrop };

// Reads and checks all three parts, from the binary files if they are complete, else from the text
// files. Cameras with unknown lenses in text models, which no image refers to, are left out. Other
// files (of newer versions, project.ini) are ignored. Throws DataError.
ColmapModel ReadColmapModel(const std::filesystem::path& folder,
                            DanglingReferences dangling = DanglingReferences::kRefuse);

// Means over the points; 0 if there are none.
double MeanReprojectionError_px(const ColmapModel& model);
double MeanTrackLength(const ColmapModel& model);

}  // namespace tetrec
