// The lens of a frame of transforms JSON files.
#include "import/transforms_lens.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace tetrec::internal {
namespace {

// 0.6 to 172 degrees.
constexpr double kMinFov_rad = 0.01, kMaxFov_rad = 3.0;
constexpr double kMaxSide_px = 65536;
constexpr double kMinFocal_px = 1e-3, kMaxFocal_px = 1e9;
constexpr double kLargestCoefficient = 1e6;
constexpr double kDegree_rad = std::numbers::pi / 180;

// Lens distortion, in the order of nerfstudio's distortion_params.
constexpr std::array kCoefficients = {"k1", "k2", "k3", "k4", "p1", "p2"};
constexpr const char* kCoefficientList = "distortion_params";

// The fields that are read here or refused by name.
constexpr std::array kLensFields = {"w",
                                    "h",
                                    "fl_x",
                                    "fl_y",
                                    "cx",
                                    "cy",
                                    "camera_angle_x",
                                    "camera_angle_y",
                                    "x_fov",
                                    "y_fov",
                                    "k1",
                                    "k2",
                                    "k3",
                                    "k4",
                                    "k5",
                                    "k6",
                                    "p1",
                                    "p2",
                                    "distortion_params",
                                    "camera_model",
                                    "is_fisheye",
                                    "ftheta_p0",
                                    "latlong",
                                    "equirectangular",
                                    "rolling_shutter"};
template <size_t kCount>
bool Contains(const std::array<const char*, kCount>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

std::optional<CheckedJson> FrameFields::FindCoefficient(const std::string& name) const {
  const bool frame_has_any =
      frame.Has(kCoefficientList) ||
      std::any_of(kCoefficients.begin(), kCoefficients.end(),
                  [&](const char* coefficient) { return frame.Has(coefficient); });
  const CheckedJson& source = frame_has_any ? frame : file;
  if (Contains(kCoefficients, name) && source.Has(kCoefficientList)) {
    const CheckedJson list = source.Field(kCoefficientList);
    if (list.Size() != kCoefficients.size()) {
      list.Fail(fmt::format("has {} items; expected {}", list.Size(),
                            fmt::join(kCoefficients.begin(), kCoefficients.end(), ", ")));
    }
    const auto place = std::find(kCoefficients.begin(), kCoefficients.end(), name);
    return list.Item(size_t(place - kCoefficients.begin()));
  }
  if (!Has(name)) return std::nullopt;
  return (*this)[name];
}

// nerfstudio's converter of RealityCapture's cameras writes coefficients as text.
double FrameFields::Coefficient(const std::string& name) const {
  const std::optional<CheckedJson> found = FindCoefficient(name);
  return found ? found->NumberOrTextIn(-kLargestCoefficient, kLargestCoefficient) : 0.0;
}

const CheckedJson& FrameFields::SourceOf(const std::string& name) const {
  constexpr std::array kFocal = {"fl_x",           "fl_y",  "camera_angle_x",
                                 "camera_angle_y", "x_fov", "y_fov"};
  const bool is_focal = Contains(kFocal, name);
  const bool frame_has_focal = std::any_of(kFocal.begin(), kFocal.end(),
                                           [&](const char* focal) { return frame.Has(focal); });
  return frame.Has(name) || (is_focal && frame_has_focal) ? frame : file;
}

bool IsLensField(const std::string& name) { return Contains(kLensFields, name); }

namespace {

double FieldOfView_rad(const CheckedJson& angle, double unit_rad) {
  const double fov_rad = angle.Number() * unit_rad;
  if (fov_rad < kMinFov_rad || fov_rad > kMaxFov_rad) {
    angle.Fail(fmt::format("is {}; expected a field of view of {} to {} radians", angle.Number(),
                           kMinFov_rad, kMaxFov_rad));
  }
  return fov_rad;
}

// Along an axis ("x", "y"); nothing if no angle is specified.
std::optional<double> FieldOfView_rad(const FrameFields& fields, const std::string& axis) {
  const std::string in_radians = "camera_angle_" + axis, in_degrees = axis + "_fov";
  if (fields.Has(in_radians)) return FieldOfView_rad(fields[in_radians], 1.0);
  if (fields.Has(in_degrees)) return FieldOfView_rad(fields[in_degrees], kDegree_rad);
  return std::nullopt;
}

std::optional<double> Focal_px(const FrameFields& fields, const std::string& axis, double size_px) {
  if (fields.Has("fl_" + axis)) return fields["fl_" + axis].NumberIn(kMinFocal_px, kMaxFocal_px);
  if (const std::optional<double> fov_rad = FieldOfView_rad(fields, axis)) {
    return 0.5 * size_px / std::tan(0.5 * *fov_rad);
  }
  return std::nullopt;
}

[[noreturn]] void FailWithoutFocal(const FrameFields& fields) {
  fields.frame.Fail(
      "has no focal length: neither the frame nor the file has fl_x (with w and h) or "
      "camera_angle_x");
}

bool IsFisheye(const FrameFields& fields) {
  for (const char* other : {"ftheta_p0", "latlong", "equirectangular"}) {
    if (fields.Has(other)) {
      fields[other].Fail(
          "belongs to a camera model that is not supported; expected a perspective or an "
          "OPENCV_FISHEYE camera");
    }
  }
  if (fields.Has("is_fisheye") && fields["is_fisheye"].Flag()) return true;
  if (!fields.Has("camera_model")) return false;
  const std::string model = fields["camera_model"].Text();
  if (model == "OPENCV_FISHEYE") return true;
  // The coefficients that exist distinguish these.
  constexpr const char* kPerspective[] = {"PERSPECTIVE",   "SIMPLE_PINHOLE", "PINHOLE",    "OPENCV",
                                          "SIMPLE_RADIAL", "RADIAL",         "FULL_OPENCV"};
  const bool known =
      std::find(std::begin(kPerspective), std::end(kPerspective), model) != std::end(kPerspective);
  if (!known) {
    fields["camera_model"].Fail(
        fmt::format("is \"{}\"; expected {} or OPENCV_FISHEYE", model,
                    fmt::join(std::begin(kPerspective), std::end(kPerspective), ", ")));
  }
  return false;
}

void RefuseCoefficients(const FrameFields& fields, std::initializer_list<const char*> names,
                        const char* kind) {
  for (const char* name : names) {
    const double value = fields.Coefficient(name);
    if (value == 0) continue;
    fields.FindCoefficient(name)->Fail(fmt::format("is {}; expected 0 for a {} lens", value, kind));
  }
}

// Appends the lens distortion to fx fy cx cy and sets the model.
void SetDistortion(const FrameFields& fields, Lens& lens) {
  const auto append = [&](std::initializer_list<const char*> names) {
    for (const char* name : names) lens.params.push_back(fields.Coefficient(name));
  };
  if (IsFisheye(fields)) {
    RefuseCoefficients(fields, {"k5", "k6"}, "fisheye");
    // nerfstudio applies p1 and p2 to coordinates that are scaled by the angle, as this model does.
    const bool is_skewed = fields.Coefficient("p1") != 0 || fields.Coefficient("p2") != 0;
    lens.model = is_skewed ? LensModel::kThinPrismFisheye : LensModel::kOpenCvFisheye;
    if (is_skewed) {
      append({"k1", "k2", "p1", "p2", "k3", "k4"});
      lens.params.resize(12);  // sx1, sy1: 0
    } else {
      append({"k1", "k2", "k3", "k4"});
    }
    return;
  }
  // Programs disagree on what these multiply: a divisor or the eighth power.
  RefuseCoefficients(fields, {"k4", "k5", "k6"}, "perspective");
  append({"k1", "k2", "p1", "p2", "k3"});
  const auto is_zero = [](double value) { return value == 0; };
  if (std::all_of(lens.params.begin() + 4, lens.params.end(), is_zero)) {
    lens.model = LensModel::kPinhole;
    lens.params.resize(4);
  } else if (lens.params.back() == 0) {
    lens.model = LensModel::kOpenCv;
    lens.params.resize(8);
  } else {
    lens.model = LensModel::kFullOpenCv;
    lens.params.resize(12);  // k4 to k6: 0
  }
}

uint64_t Side_px(const CheckedJson& json) {
  const double side_px = json.NumberIn(1, kMaxSide_px);  // often written like 1080.0
  if (side_px != std::floor(side_px))
    json.Fail(fmt::format("is {}; expected whole pixels", side_px));
  return uint64_t(side_px);
}

}  // namespace

Lens ReadLens(const FrameFields& fields) {
  Lens lens;
  lens.width = Side_px(fields["w"]);
  lens.height = Side_px(fields["h"]);
  const auto width = double(lens.width), height = double(lens.height);
  const std::optional<double> fx = Focal_px(fields, "x", width), fy = Focal_px(fields, "y", height);
  if (!fx && !fy) FailWithoutFocal(fields);
  const auto principal_point_px = [&](const char* name, double size_px) {
    return fields.Has(name) ? fields[name].NumberIn(-kMaxSide_px, 2 * kMaxSide_px) : 0.5 * size_px;
  };
  lens.params = {fx.value_or(fy.value_or(0)), fy.value_or(fx.value_or(0)),
                 principal_point_px("cx", width), principal_point_px("cy", height)};
  SetDistortion(fields, lens);
  return lens;
}

void ReadFieldOfView(const FrameFields& fields, PosedPicture& picture) {
  for (const char* name : {"fl_x", "fl_y", "cx", "cy"}) {
    if (fields.Has(name)) fields[name].Fail("is in pixels of an image of w x h; add w and h");
  }
  if (IsFisheye(fields)) fields.frame.Fail("has a fisheye lens but no image size; add w and h");
  for (const char* name : kCoefficients) {
    if (fields.Coefficient(name) != 0) {
      fields.FindCoefficient(name)->Fail(
          "is the lens distortion of an image of w x h; add w and h");
    }
  }
  const std::optional<double> x = FieldOfView_rad(fields, "x"), y = FieldOfView_rad(fields, "y");
  if (!x && !y) FailWithoutFocal(fields);
  picture.horizontal_fov_rad = x.value_or(0);
  picture.vertical_fov_rad = y.value_or(0);
}

}  // namespace tetrec::internal
