// Camera lenses with distortion: the models, their parameters, and where a lens puts a direction in
// its image. The models and the order of their parameters are those of COLMAP's documentation,
// "Camera Models".
#pragma once

#include "core/words.h"

#include <glm/glm.hpp>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace tetrec {

// COLMAP's files store these numbers and names. Each model's parameters follow it.
enum class LensModel : int {
  kUnknown = -1,                 // named in Lens::unknown_model
  kSimplePinhole = 0,            // f cx cy
  kPinhole = 1,                  // fx fy cx cy
  kSimpleRadial = 2,             // f cx cy k1
  kRadial = 3,                   // f cx cy k1 k2
  kOpenCv = 4,                   // fx fy cx cy k1 k2 p1 p2
  kOpenCvFisheye = 5,            // fx fy cx cy k1 k2 k3 k4
  kFullOpenCv = 6,               // fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6
  kFov = 7,                      // fx fy cx cy omega
  kSimpleRadialFisheye = 8,      // f cx cy k1
  kRadialFisheye = 9,            // f cx cy k1 k2
  kThinPrismFisheye = 10,        // fx fy cx cy k1 k2 p1 p2 k3 k4 sx1 sy1
  kRadTanThinPrismFisheye = 11,  // fx fy cx cy k0 k1 k2 k3 k4 k5 p0 p1 s0 s1 s2 s3; from here on
  kSimpleDivision = 12,          // f cx cy k                            later than COLMAP 3.10
  kDivision = 13,                // fx fy cx cy k
  kSimpleFisheye = 14,           // f cx cy
  kFisheye = 15,                 // fx fy cx cy
  kEucm = 16                     // fx fy cx cy alpha beta
};
template <>
inline constexpr auto kWords<LensModel> = std::to_array<Word<LensModel>>(
    {{LensModel::kSimplePinhole, "SIMPLE_PINHOLE"},
     {LensModel::kPinhole, "PINHOLE"},
     {LensModel::kSimpleRadial, "SIMPLE_RADIAL"},
     {LensModel::kRadial, "RADIAL"},
     {LensModel::kOpenCv, "OPENCV"},
     {LensModel::kOpenCvFisheye, "OPENCV_FISHEYE"},
     {LensModel::kFullOpenCv, "FULL_OPENCV"},
     {LensModel::kFov, "FOV"},
     {LensModel::kSimpleRadialFisheye, "SIMPLE_RADIAL_FISHEYE"},
     {LensModel::kRadialFisheye, "RADIAL_FISHEYE"},
     {LensModel::kThinPrismFisheye, "THIN_PRISM_FISHEYE"},
     {LensModel::kRadTanThinPrismFisheye, "RAD_TAN_THIN_PRISM_FISHEYE"},
     {LensModel::kSimpleDivision, "SIMPLE_DIVISION"},
     {LensModel::kDivision, "DIVISION"},
     {LensModel::kSimpleFisheye, "SIMPLE_FISHEYE"},
     {LensModel::kFisheye, "FISHEYE"},
     {LensModel::kEucm, "EUCM"}});

struct Lens {
  LensModel model = LensModel::kSimplePinhole;
  uint64_t width = 0, height = 0;  // of its image [px]
  std::vector<double> params;      // as listed at the model; lengths in pixels
  std::string unknown_model = {};  // the name that a file gives, if the model is kUnknown
};

bool IsKnown(LensModel model);

// Number of parameters of a known model.
int ParamCount(LensModel model);
// How many of them, the first ones, are focal lengths: 1 for both axes, or one per axis. The centre
// follows.
int FocalLengths(LensModel model);

// What is wrong with a model, given by its number or name, that is not one of these.
std::string ComplaintOnLensModel(const std::string& model);
// What is wrong with the parameters: a focal length that is not positive, an EUCM lens that does
// not bend. Empty if nothing is wrong.
std::string ComplaintOnLens(const Lens& lens);

// The lens of a copy of the image that has another size. Models with one focal length become their
// counterparts with two, because the rounded sides scale differently.
Lens ScaledLens(const Lens& lens, int width, int height);

// Pixel of the direction (x, y, 1) in the camera frame. Throws DataError for an unknown model.
glm::dvec2 DistortedImageFromCam(const Lens& lens, const glm::dvec2& direction);
// The inverse, by Newton's iteration. Throws DataError if the iteration does not converge (a lens
// model that folds over inside the image) or the pixel looks sideways or backwards.
glm::dvec2 CamFromDistortedImage(const Lens& lens, const glm::dvec2& pixel);

}  // namespace tetrec
