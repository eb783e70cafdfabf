// COLMAP's sparse models: a careful reader of cameras.bin, images.bin and points3D.bin (COLMAP's
// own trusts its input). Format: COLMAP documentation, "Output Format".
#pragma once

#include "geometry/rigid3.h"

#include <glm/glm.hpp>

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace tetrec {

// COLMAP's camera models, by its numbers; behind each its parameters.
enum ColmapLens : int {
  kColmapUnknownLens = -1,         // of a text model, see ColmapCamera::unknown_lens
  kColmapSimplePinhole = 0,        // f cx cy
  kColmapPinhole = 1,              // fx fy cx cy
  kColmapSimpleRadial = 2,         // f cx cy k1
  kColmapRadial = 3,               // f cx cy k1 k2
  kColmapOpenCv = 4,               // fx fy cx cy k1 k2 p1 p2
  kColmapOpenCvFisheye = 5,        // fx fy cx cy k1 k2 k3 k4
  kColmapFullOpenCv = 6,           // fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6
  kColmapFov = 7,                  // fx fy cx cy omega
  kColmapSimpleRadialFisheye = 8,  // f cx cy k1
  kColmapRadialFisheye = 9,        // f cx cy k1 k2
  kColmapThinPrismFisheye = 10,    // fx fy cx cy k1 k2 p1 p2 k3 k4 sx1 sy1
  // Of versions after 3.10.
  kColmapRadTanThinPrismFisheye = 11,  // fx fy cx cy k0 k1 k2 k3 k4 k5 p0 p1 s0 s1 s2 s3
  kColmapSimpleDivision = 12,          // f cx cy k
  kColmapDivision = 13,                // fx fy cx cy k
  kColmapSimpleFisheye = 14,           // f cx cy
  kColmapFisheye = 15,                 // fx fy cx cy
  kColmapEucm = 16                     // fx fy cx cy alpha beta
};

struct ColmapCamera {
  int model = kColmapSimplePinhole;  // one of ColmapLens
  uint64_t width = 0, height = 0;
  std::vector<double> params;
  std::string unknown_lens = {};  // the model's name where it is none of these
};

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
  std::map<uint32_t, ColmapCamera> cameras;
  std::map<uint32_t, ColmapImage> images;
  std::map<uint64_t, ColmapPoint> points;
};

// Each part: sizes, counts, finite numbers, unique ids, known camera models. Throws DataError with
// the name and the byte.
std::map<uint32_t, ColmapCamera> ParseColmapCameras(std::span<const uint8_t> bytes,
                                                    const std::string& name);
std::map<uint32_t, ColmapImage> ParseColmapImages(std::span<const uint8_t> bytes,
                                                  const std::string& name);
std::map<uint64_t, ColmapPoint> ParseColmapPoints(std::span<const uint8_t> bytes,
                                                  const std::string& name);

// Whether the parts fit each other: images have names of their own and refer to cameras whose
// lenses are known, tracks and observations to each other. Throws DataError("<name>: ...").
void CheckColmapModel(const ColmapModel& model, const std::string& name);

// All three, binary where they are there, else text, and checked; cameras of text models with
// unknown lenses, which no image has, are left out. Other files (of newer versions,
// project.ini) do not matter. Throws DataError.
ColmapModel ReadColmapModel(const std::filesystem::path& folder);

// Means over the points; 0 where there are none.
double MeanReprojectionError_px(const ColmapModel& model);
double MeanTrackLength(const ColmapModel& model);

}  // namespace tetrec
