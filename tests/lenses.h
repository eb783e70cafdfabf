// Lenses for tests, of every model.
#pragma once

#include "geometry/lens.h"

#include <vector>

namespace tetrec {

// One lens of every model of COLMAP 3.8, distorted by several per cent of the width.
inline std::vector<Lens> LensesOfColmap38() {
  return {{LensModel::kSimplePinhole, 640, 480, {500, 330, 235}},
          {LensModel::kPinhole, 640, 480, {500, 510, 330, 235}},
          {LensModel::kSimpleRadial, 640, 480, {500, 330, 235, 0.1}},
          {LensModel::kRadial, 640, 480, {500, 330, 235, -0.15, 0.05}},
          {LensModel::kOpenCv, 640, 480, {500, 510, 330, 235, -0.12, 0.05, 0.004, -0.003}},
          {LensModel::kOpenCvFisheye, 640, 480, {400, 410, 330, 235, 0.05, -0.03, 0.02, -0.01}},
          {LensModel::kFullOpenCv,
           640,
           480,
           {500, 510, 330, 235, 0.2, 0.1, 0.003, -0.002, 0.03, 0.3, 0.05, 0.02}},
          {LensModel::kFov, 640, 480, {420, 430, 330, 235, 0.9}},
          {LensModel::kSimpleRadialFisheye, 640, 480, {400, 330, 235, 0.06}},
          {LensModel::kRadialFisheye, 640, 480, {400, 330, 235, 0.06, -0.04}},
          {LensModel::kThinPrismFisheye,
           640,
           480,
           {400, 410, 330, 235, 0.05, -0.03, 0.003, -0.002, 0.02, -0.01, 0.01, -0.008}}};
}

inline Lens RadTanLens() {
  return {LensModel::kRadTanThinPrismFisheye,
          640,
          480,
          {400, 410, 330, 235, 0.05, -0.03, 0.02, -0.01, 0.006, -0.002, 0.003, -0.002, 0.01, -0.004,
           -0.008, 0.003}};
}

// Also one of every model of later versions.
inline std::vector<Lens> LensesOfEveryModel() {
  std::vector<Lens> lenses = LensesOfColmap38();
  lenses.push_back(RadTanLens());
  lenses.push_back({LensModel::kSimpleDivision, 640, 480, {500, 330, 235, -0.2}});
  lenses.push_back({LensModel::kDivision, 640, 480, {500, 510, 330, 235, 0.15}});
  lenses.push_back({LensModel::kSimpleFisheye, 640, 480, {400, 330, 235}});
  lenses.push_back({LensModel::kFisheye, 640, 480, {400, 410, 330, 235}});
  lenses.push_back({LensModel::kEucm, 640, 480, {400, 410, 330, 235, 0.6, 1.2}});
  return lenses;
}

// A strong barrel lens with all terms; 1 % of the width at the corners and more.
inline Lens OpenCvLens() {
  return {LensModel::kOpenCv, 640, 480, {500, 510, 330, 235, -0.12, 0.05, 0.002, -0.003}};
}
inline Lens PinholeLens() { return {LensModel::kPinhole, 640, 480, {500, 510, 330, 235}}; }

}  // namespace tetrec
