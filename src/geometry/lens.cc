// The table of lens models, checks of parameters, and scaled lenses.
#include "geometry/lens.h"

#include <fmt/format.h>

#include <algorithm>

namespace tetrec {
namespace {

struct ParamLayout {
  int focal_lengths;  // the first parameters: one for both axes, or one per axis
  int params;
};

// Indexed by the model's number.
constexpr ParamLayout kLayouts[] = {{1, 3},  {2, 4}, {1, 4}, {1, 5}, {2, 8},  {2, 8},
                                    {2, 12}, {2, 5}, {1, 4}, {1, 5}, {2, 12}, {2, 16},
                                    {1, 4},  {2, 5}, {1, 3}, {2, 4}, {2, 6}};
static_assert(std::size(kLayouts) == kWords<LensModel>.size());

const ParamLayout& LayoutOf(LensModel model) {
  TETREC_CHECK(IsKnown(model), "a lens of an unknown model has no layout");
  return kLayouts[size_t(model)];
}

// The counterpart with one focal length per axis; the model itself if it has two already.
LensModel WithTwoFocalLengths(LensModel model) {
  switch (model) {
    case LensModel::kSimplePinhole:
      return LensModel::kPinhole;
    case LensModel::kSimpleRadial:
    case LensModel::kRadial:
      return LensModel::kOpenCv;
    case LensModel::kSimpleRadialFisheye:
    case LensModel::kRadialFisheye:
      return LensModel::kOpenCvFisheye;
    case LensModel::kSimpleDivision:
      return LensModel::kDivision;
    case LensModel::kSimpleFisheye:
      return LensModel::kFisheye;
    default:
      return model;
  }
}

}  // namespace

bool IsKnown(LensModel model) {
  return int(model) >= 0 && size_t(model) < kWords<LensModel>.size();
}

int ParamCount(LensModel model) { return LayoutOf(model).params; }

int FocalLengths(LensModel model) { return LayoutOf(model).focal_lengths; }

std::string ComplaintOnLensModel(const std::string& model) {
  std::string names;
  for (const Word<LensModel>& entry : kWords<LensModel>) {
    names += fmt::format("{}{}", names.empty() ? "" : ", ", entry.word);
  }
  return fmt::format("camera model {} is unknown (expected 0 to {}: {})", model,
                     kWords<LensModel>.size() - 1, names);
}

std::string ComplaintOnLens(const Lens& lens) {
  const std::vector<double>& p = lens.params;
  const bool has_one = FocalLengths(lens.model) == 1;
  const double least = has_one ? p[0] : std::min(p[0], p[1]);
  if (!(least > 0)) return fmt::format("a camera has the focal length {} px", least);
  if (lens.model == LensModel::kEucm && !(p[4] >= 0 && p[4] <= 1 && p[5] > 0)) {
    return fmt::format(
        "an EUCM camera has alpha {} and beta {}; expected alpha 0 to 1 and beta above 0", p[4],
        p[5]);
  }
  return "";
}

Lens ScaledLens(const Lens& lens, int width, int height) {
  Lens scaled = lens;
  std::vector<double>& p = scaled.params;
  scaled.model = WithTwoFocalLengths(lens.model);
  if (scaled.model != lens.model) {
    p.insert(p.begin(), p[0]);
    p.resize(size_t(ParamCount(scaled.model)), 0.0);
  }
  const double x = width / double(lens.width), y = height / double(lens.height);
  p[0] *= x, p[1] *= y, p[2] *= x, p[3] *= y;
  scaled.width = uint64_t(width);
  scaled.height = uint64_t(height);
  return scaled;
}

}  // namespace tetrec
