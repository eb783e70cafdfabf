// Readers of transforms JSON files.
#include "scene/transforms.h"

#include "core/error.h"
#include "core/file.h"
#include "core/log.h"
#include "core/short_list.h"
#include "geometry/rotation.h"
#include "scene/checked_json.h"
#include "scene/missing_pictures.h"
#include "scene/scene_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <unordered_map>

namespace tetrec {
namespace {

struct SplitFile {
  const char* name;
  Split split;
};
constexpr SplitFile kSplitFiles[] = {{"transforms_train.json", Split::kTrain},
                                     {"transforms_val.json", Split::kValidation},
                                     {"transforms_test.json", Split::kTest}};

// 0.6 to 172 degrees.
constexpr double kMinFov_rad = 0.01, kMaxFov_rad = 3.0;
constexpr double kMaxSide_px = 65536;
constexpr double kMinFocal_px = 1e-3, kMaxFocal_px = 1e9;
constexpr double kLargestCoefficient = 1e6;
// The files hold floats (1e-7); some writers print six digits.
constexpr double kRotationTolerance = 1e-4;
constexpr double kFarthestCamera = 1e9;
constexpr double kDegree_rad = std::numbers::pi / 180;

// Tried in this order behind a file path that names no file.
constexpr const char* kExtensions[] = {".png", ".jpg", ".jpeg", ".PNG", ".JPG", ".JPEG", ".exr"};

// Lens distortion, in the order of nerfstudio's distortion_params.
constexpr std::array kCoefficients = {"k1", "k2", "k3", "k4", "p1", "p2"};
constexpr const char* kCoefficientList = "distortion_params";

// What is read here or refused by name; other fields are listed as unused.
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
constexpr std::array kFileFields = {"frames",           "aabb",
                                    "aabb_scale",       "scale",
                                    "offset",           "ply_file_path",
                                    "train_filenames",  "val_filenames",
                                    "test_filenames",   "normal_mts_args",
                                    "from_na",          "white_transparent",
                                    "black_transparent"};
constexpr std::array kFrameFields = {"file_path", "transform_matrix", "mask_path",
                                     "depth_file_path", "depth_path"};

template <size_t kCount>
bool Holds(const std::array<const char*, kCount>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// A frame, with the fields that it does not have itself taken from the file.
struct FrameFields {
  CheckedJson frame, file;

  bool Has(const std::string& name) const { return TellerOf(name).Has(name); }
  CheckedJson operator[](const std::string& name) const { return TellerOf(name).Field(name); }
  // Of the lens distortion; none where it is not told. A list comes before single ones, as in
  // nerfstudio; the file's list does not count for a frame with words of its own.
  std::optional<CheckedJson> FindCoefficient(const std::string& name) const {
    const bool frame_tells =
        frame.Has(kCoefficientList) ||
        std::any_of(kCoefficients.begin(), kCoefficients.end(),
                    [&](const char* coefficient) { return frame.Has(coefficient); });
    const CheckedJson& teller = frame_tells ? frame : file;
    if (Holds(kCoefficients, name) && teller.Has(kCoefficientList)) {
      const CheckedJson list = teller.Field(kCoefficientList);
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
  double Coefficient(const std::string& name) const {
    const std::optional<CheckedJson> told = FindCoefficient(name);
    return told ? told->NumberIn(-kLargestCoefficient, kLargestCoefficient) : 0.0;
  }

 private:
  // A frame that tells its focal length in any way goes by its own words alone.
  const CheckedJson& TellerOf(const std::string& name) const {
    constexpr std::array kFocal = {"fl_x",           "fl_y",  "camera_angle_x",
                                   "camera_angle_y", "x_fov", "y_fov"};
    const bool is_focal = Holds(kFocal, name);
    const bool frame_tells_focal = std::any_of(kFocal.begin(), kFocal.end(),
                                               [&](const char* focal) { return frame.Has(focal); });
    return frame.Has(name) || (is_focal && frame_tells_focal) ? frame : file;
  }
};

Rigid3 CamFromInput(const CheckedJson& json) {
  if (json.Size() != 3 && json.Size() != 4) {
    json.Fail(fmt::format("has {} rows; expected 3 or 4", json.Size()));
  }
  double rows[4][4] = {{}, {}, {}, {0, 0, 0, 1}};
  for (size_t i = 0; i < json.Size(); ++i) {
    const CheckedJson row = json.Item(i);
    if (row.Size() != 4) row.Fail(fmt::format("has {} items; expected 4 numbers", row.Size()));
    for (size_t j = 0; j < 4; ++j) {
      rows[i][j] = row.Item(j).NumberIn(-kFarthestCamera, kFarthestCamera);
    }
  }
  const bool affine = rows[3][0] == 0 && rows[3][1] == 0 && rows[3][2] == 0 && rows[3][3] == 1;
  if (!affine) json.Item(3).Fail("is not 0 0 0 1, so the matrix is no pose");
  Rigid3 input_from_opengl;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) input_from_opengl.rotation[j][i] = rows[i][j];
    input_from_opengl.translation[i] = rows[i][3];
  }
  const double distance = DistanceFromRotation(input_from_opengl.rotation);
  if (!(distance <= kRotationTolerance)) {
    json.Fail(fmt::format("is no rigid pose: R^T R is off by {:.2g} (scaled or mirrored axes)",
                          distance));
  }
  input_from_opengl.rotation = NearestRotation(input_from_opengl.rotation);
  const Rigid3 cam_from_opengl{glm::dmat3(1, 0, 0, 0, -1, 0, 0, 0, -1), glm::dvec3(0.0)};
  return cam_from_opengl * input_from_opengl.Inverse();
}

double FieldOfView_rad(const CheckedJson& angle, double unit_rad) {
  const double fov_rad = angle.Number() * unit_rad;
  if (fov_rad < kMinFov_rad || fov_rad > kMaxFov_rad) {
    angle.Fail(fmt::format("is {}; expected a field of view of {} to {} radians", angle.Number(),
                           kMinFov_rad, kMaxFov_rad));
  }
  return fov_rad;
}

// Along an axis ("x", "y"); none where no angle is told.
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
      "has no focal length: neither it nor the file tells fl_x (with w and h) or camera_angle_x");
}

bool IsFisheye(const FrameFields& fields) {
  for (const char* other : {"ftheta_p0", "latlong", "equirectangular"}) {
    if (fields.Has(other)) {
      fields[other].Fail(
          "belongs to a camera that is not read; expected a perspective or an "
          "OPENCV_FISHEYE camera");
    }
  }
  if (fields.Has("is_fisheye") && fields["is_fisheye"].Flag()) return true;
  if (!fields.Has("camera_model")) return false;
  const std::string model = fields["camera_model"].Text();
  if (model == "OPENCV_FISHEYE") return true;
  // The coefficients that are there tell these apart.
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
void SetDistortion(const FrameFields& fields, ColmapCamera& lens) {
  const auto append = [&](std::initializer_list<const char*> names) {
    for (const char* name : names) lens.params.push_back(fields.Coefficient(name));
  };
  if (IsFisheye(fields)) {
    RefuseCoefficients(fields, {"p1", "p2", "k5", "k6"}, "fisheye");
    lens.model = kColmapOpenCvFisheye;
    append({"k1", "k2", "k3", "k4"});
    return;
  }
  // Programs disagree on what they are: a divisor's or the eighth power's.
  RefuseCoefficients(fields, {"k4", "k5", "k6"}, "perspective");
  append({"k1", "k2", "p1", "p2", "k3"});
  const auto is_zero = [](double value) { return value == 0; };
  if (std::all_of(lens.params.begin() + 4, lens.params.end(), is_zero)) {
    lens.model = kColmapPinhole;
    lens.params.resize(4);
  } else if (lens.params.back() == 0) {
    lens.model = kColmapOpenCv;
    lens.params.resize(8);
  } else {
    lens.model = kColmapFullOpenCv;
    lens.params.resize(12);  // k4 to k6: 0
  }
}

uint64_t Side_px(const CheckedJson& json) {
  const double side_px = json.NumberIn(1, kMaxSide_px);  // often written as 1080.0
  if (side_px != std::floor(side_px)) json.Fail(fmt::format("is {}; expected pixels", side_px));
  return uint64_t(side_px);
}

ColmapCamera ReadLens(const FrameFields& fields) {
  ColmapCamera lens;
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

// Of a file that does not tell the pictures' size: nothing in pixels, no distortion.
void ReadFieldOfView(const FrameFields& fields, PosedPicture& picture) {
  for (const char* name : {"fl_x", "fl_y", "cx", "cy"}) {
    if (fields.Has(name)) fields[name].Fail("is in pixels of a picture of w x h; add w and h");
  }
  if (IsFisheye(fields)) fields.frame.Fail("has a fisheye lens but no picture size; add w and h");
  for (const char* name : kCoefficients) {
    if (fields.Coefficient(name) != 0) {
      fields.FindCoefficient(name)->Fail(
          "is the lens distortion of a picture of w x h; add w and h");
    }
  }
  const std::optional<double> x = FieldOfView_rad(fields, "x"), y = FieldOfView_rad(fields, "y");
  if (!x && !y) FailWithoutFocal(fields);
  picture.horizontal_fov_rad = x.value_or(0);
  picture.vertical_fov_rad = y.value_or(0);
}

// The normalised path that a field names, relative to the folder.
std::filesystem::path PathInside(const CheckedJson& json, const std::filesystem::path& folder) {
  const std::filesystem::path relative = std::filesystem::path(json.Text()).lexically_normal();
  if (!StaysInside(relative)) {
    json.Fail(
        fmt::format("is \"{}\"; expected a path inside {}", relative.string(), folder.string()));
  }
  return relative;
}

bool IsFile(const std::filesystem::path& path) {
  std::error_code unusable;  // e.g. a name too long for the file system: not there either
  return std::filesystem::is_regular_file(path, unusable);
}

// The picture that "file_path" means: as written, else with an extension; empty where neither is
// there.
std::filesystem::path FindPicture(const std::filesystem::path& as_written) {
  if (IsFile(as_written)) return as_written;
  for (const char* extension : kExtensions) {
    const std::filesystem::path extended = as_written.string() + extension;
    if (IsFile(extended)) return extended;
  }
  return {};
}

// What instant-ngp or nerfstudio may make something of and this reader does not, gathered over the
// files of a data set.
struct Unused {
  std::set<std::string> fields;
  std::set<std::string> transparencies;
  size_t depths = 0, alphas = 0, dynamic_masks = 0, rays = 0;
};

// Names come from outside and go into the log.
std::string Shown(std::string name) {
  constexpr size_t kLongest = 60;
  if (name.size() > kLongest) name = name.substr(0, kLongest) + "...";
  std::replace_if(
      name.begin(), name.end(), [](char c) { return uint8_t(c) < 0x20 || c == 0x7F; }, '?');
  return name;
}

// Where each row of pixels has a pose of its own, no single one is right.
void RefuseRollingShutter(const CheckedJson& json) {
  if (!json.Has("rolling_shutter")) return;
  const CheckedJson times = json.Field("rolling_shutter");
  bool is_off = times.IsArray() || times.IsOff();
  for (size_t i = 0; times.IsArray() && i < times.Size(); ++i) {
    is_off = is_off && times.Item(i).Number() == 0;
  }
  if (!is_off) {
    times.Fail(
        "is not 0: pictures whose rows were taken one after the other are not read; give them "
        "rectified, with rolling_shutter 0");
  }
}

// Marks of instant-ngp's for poses along other axes than OpenGL's.
void RefuseOtherAxes(const CheckedJson& json) {
  for (const char* mark : {"normal_mts_args", "from_na"}) {
    if (!json.Has(mark) || json.Field(mark).IsOff()) continue;
    json.Field(mark).Fail(
        "tells that the poses follow axes other than OpenGL's (x right, y up, z back), which are "
        "not read; convert them and take it out");
  }
}

void NoteFieldsOfFile(const CheckedJson& json, Unused& unused) {
  for (const std::string& name : json.Names()) {
    if (!Holds(kLensFields, name) && !Holds(kFileFields, name)) unused.fields.insert(Shown(name));
  }
  for (const char* flag : {"white_transparent", "black_transparent"}) {
    if (json.Has(flag) && !json.Field(flag).IsOff()) unused.transparencies.insert(flag);
  }
}

void NoteFieldsOfFrame(const CheckedJson& json, Unused& unused) {
  for (const std::string& name : json.Names()) {
    if (!Holds(kLensFields, name) && !Holds(kFrameFields, name)) {
      unused.fields.insert("frames[]." + Shown(name));
    }
  }
  unused.depths += json.Has("depth_file_path") || json.Has("depth_path");
}

// What instant-ngp takes from files beside a picture.
void NoteFilesBeside(const std::filesystem::path& picture, const std::filesystem::path& as_written,
                     Unused& unused) {
  const std::filesystem::path folder = picture.parent_path();
  const std::string stem = picture.stem().string(), extension = picture.extension().string();
  unused.alphas += IsFile(as_written.string() + ".alpha" + extension) ||
                   IsFile(folder / (stem + ".alpha" + extension)) ||
                   IsFile(folder / (stem + ".alpha.png"));
  unused.dynamic_masks += IsFile(folder / ("dynamic_mask_" + stem + ".png"));
  unused.rays += IsFile(folder / ("rays_" + stem + ".dat"));
}

// Once for a data set.
void TellUnused(const std::string& name, const Unused& unused) {
  const auto warn = [&](size_t count, const char* what) {
    if (count > 0) LogWarning("{}: {}: {}; not used", name, what, count);
  };
  warn(unused.alphas, "pictures with their alpha in a file beside them (NAME.alpha.png)");
  warn(unused.dynamic_masks, "pictures with a mask of what moves beside them (dynamic_mask_NAME)");
  warn(unused.rays, "pictures with the rays of their pixels beside them (rays_NAME.dat)");
  if (!unused.transparencies.empty()) {
    LogWarning("{}: {} is not used: colours stay as they are; give the pictures alpha", name,
               fmt::join(unused.transparencies, ", "));
  }
  if (unused.depths > 0) {
    LogInfo("{}: depth pictures named by frames: {}; not used", name, unused.depths);
  }
  if (!unused.fields.empty()) {
    constexpr size_t kMost = 50;
    const std::vector<std::string> fields(unused.fields.begin(), unused.fields.end());
    LogInfo("{}: fields that nothing here depends on: {}", name, ShortList(fields, kMost));
  }
}

// A frame's picture, and its file_path, normalised.
struct Frame {
  PosedPicture picture;
  std::filesystem::path relative;
};

// A picture that is not there has no file; then its mask need not be there either.
Frame ReadFrame(const FrameFields& fields, const std::filesystem::path& folder, Unused& unused) {
  const CheckedJson& json = fields.frame;
  Frame frame;
  frame.relative = PathInside(json.Field("file_path"), folder);
  RefuseRollingShutter(json);
  NoteFieldsOfFrame(json, unused);
  PosedPicture& picture = frame.picture;
  picture.file = FindPicture(folder / frame.relative);
  if (!picture.file.empty()) NoteFilesBeside(picture.file, folder / frame.relative, unused);
  const bool has_extension = picture.file == folder / frame.relative;
  std::filesystem::path name = frame.relative;
  if (has_extension) name.replace_extension();
  picture.name = name.generic_string();
  picture.cam_from_input = CamFromInput(json.Field("transform_matrix"));
  if (json.Has("mask_path")) {
    picture.mask = folder / PathInside(json.Field("mask_path"), folder);
    if (!picture.file.empty() && !IsFile(picture.mask)) {
      json.Field("mask_path")
          .Fail(fmt::format("names a missing mask: {} is not there", picture.mask.string()));
    }
  }
  if (fields.Has("w") || fields.Has("h")) {
    picture.lens = ReadLens(fields);
  } else {
    ReadFieldOfView(fields, picture);
  }
  return frame;
}

std::vector<Frame> ReadFrames(const CheckedJson& json, const std::filesystem::path& path,
                              Unused& unused) {
  RefuseRollingShutter(json);
  RefuseOtherAxes(json);
  NoteFieldsOfFile(json, unused);
  const CheckedJson items = json.Field("frames");
  std::vector<Frame> frames;
  for (size_t i = 0; i < items.Size(); ++i) {
    frames.push_back(ReadFrame({items.Item(i), json}, path.parent_path(), unused));
  }
  return frames;
}

void HandleMissingFrames(const std::filesystem::path& folder, MissingPictures missing,
                         Dataset& set) {
  HandleMissingPictures(
      folder, missing, set,
      fmt::format(", as they are written or with {}",
                  fmt::join(std::begin(kExtensions), std::end(kExtensions), ", ")));
}

// Which file a picture's name came from; a view may be listed once.
using FileOfName = std::unordered_map<std::string, std::string>;

void AddPicture(const PosedPicture& picture, const std::filesystem::path& path, FileOfName& files,
                Dataset& set) {
  const std::string file = path.filename().string();
  const auto [other, is_new] = files.emplace(picture.name, file);
  if (!is_new) {
    throw DataError(
        fmt::format("{}: picture \"{}\" of {} is in {} already; a view may be listed once",
                    path.parent_path().string(), picture.name, file, other->second));
  }
  set.pictures.push_back(picture);
}

// Side by side in transforms.json: a list of file paths for each split.
struct SplitList {
  const char* name;
  Split split;
};
constexpr SplitList kSplitLists[] = {{"train_filenames", Split::kTrain},
                                     {"val_filenames", Split::kValidation},
                                     {"test_filenames", Split::kTest}};

// The split that each file path is listed in. Some writers list the same views for validation and
// test: these are test views.
std::map<std::filesystem::path, Split> ReadSplitLists(const CheckedJson& json,
                                                      const std::filesystem::path& folder,
                                                      const std::vector<Frame>& frames) {
  std::set<std::filesystem::path> known;
  for (const Frame& frame : frames) known.insert(frame.relative);
  std::map<std::filesystem::path, Split> splits;
  for (const SplitList& list : kSplitLists) {
    if (!json.Has(list.name)) continue;
    const CheckedJson items = json.Field(list.name);
    for (size_t i = 0; i < items.Size(); ++i) {
      const CheckedJson item = items.Item(i);
      const std::filesystem::path path = PathInside(item, folder);
      if (!known.contains(path))
        item.Fail(fmt::format("is \"{}\", which no frame has", path.string()));
      const auto [other, is_new] = splits.emplace(path, list.split);
      if (is_new || other->second == list.split) continue;
      if (other->second == Split::kTrain) {
        item.Fail(fmt::format("is \"{}\", which is in train_filenames too", path.string()));
      }
      other->second = list.split;
    }
  }
  return splits;
}

// Sets the splits; takes out the frames that no list names.
void ApplySplitLists(const CheckedJson& json, const std::filesystem::path& path,
                     std::vector<Frame>& frames) {
  const auto splits = ReadSplitLists(json, path.parent_path(), frames);
  for (Frame& frame : frames) {
    if (const auto found = splits.find(frame.relative); found != splits.end()) {
      frame.picture.split = found->second;
    }
  }
  if (!json.Has("train_filenames")) return;
  const size_t left_out =
      std::erase_if(frames, [&](const Frame& frame) { return !splits.contains(frame.relative); });
  if (left_out > 0) {
    LogWarning(
        "{}: frames in none of train_filenames, val_filenames and test_filenames: {}; "
        "left out",
        path.string(), left_out);
  }
}

// Where instant-ngp puts the input: input * scale + offset, the box around 0.5. (It then swaps axes
// cyclically, which leaves a cube around (0.5, 0.5, 0.5) where it is.)
std::optional<Bounds3> ReadBox(const CheckedJson& json) {
  if (json.Has("aabb")) {
    const CheckedJson aabb = json.Field("aabb");
    if (aabb.Size() != 2) aabb.Fail(fmt::format("has {} items; expected 2 corners", aabb.Size()));
    const Bounds3 box{aabb.Item(0).Vector3(), aabb.Item(1).Vector3()};
    if (!glm::all(glm::lessThan(box.min, box.max))) aabb.Fail("is no box from min to max");
    return box;
  }
  if (!json.Has("aabb_scale")) return std::nullopt;
  const double side = json.Field("aabb_scale").NumberIn(1e-3, 1e6);
  const double scale = json.Has("scale") ? json.Field("scale").NumberIn(1e-6, 1e6) : 0.33;
  glm::dvec3 offset(0.5);
  if (json.Has("offset")) {
    const CheckedJson told = json.Field("offset");
    offset = told.IsArray() ? told.Vector3() : glm::dvec3(told.Number());
  }
  const glm::dvec3 center = (0.5 - offset) / scale;
  const double half = 0.5 * side / scale;
  return Bounds3{center - half, center + half};
}

// Sets with and without the file go around.
void ReadPoints(const CheckedJson& json, const std::filesystem::path& folder, Dataset& set) {
  constexpr const char* kField = "ply_file_path";
  if (!json.Has(kField)) return;
  const std::filesystem::path relative = PathInside(json.Field(kField), folder);
  if (IsFile(folder / relative)) {
    set.points = ReadColoredPoints(folder / relative);
  } else {
    set.missing_files.push_back(relative.string());
  }
}

}  // namespace

Dataset ReadNerfSynthetic(const std::filesystem::path& folder, MissingPictures missing) {
  if (!std::filesystem::is_directory(folder)) {
    throw DataError(
        fmt::format("{}: no such folder; expected a NeRF-synthetic data set", folder.string()));
  }
  Dataset set;
  set.has_split = true;
  FileOfName files;
  Unused unused;
  for (const SplitFile& split_file : kSplitFiles) {
    const std::filesystem::path path = folder / split_file.name;
    if (!std::filesystem::exists(path)) {
      set.missing_files.push_back(split_file.name);
      if (split_file.split != Split::kTrain) continue;
      throw DataError(
          fmt::format("{}: no {}; a NeRF-synthetic data set has transforms_train.json, and usually "
                      "transforms_val.json and transforms_test.json",
                      folder.string(), split_file.name));
    }
    const nlohmann::json file = ReadJson(path);
    const CheckedJson json(file, path);
    for (Frame& frame : ReadFrames(json, path, unused)) {
      frame.picture.split = split_file.split;
      AddPicture(frame.picture, path, files, set);
    }
    if (split_file.split == Split::kTrain) set.box_in_input = ReadBox(json);
    if (split_file.split == Split::kTrain && set.pictures.empty()) {
      throw DataError(fmt::format("{}: frames is empty; expected training views", path.string()));
    }
  }
  HandleMissingFrames(folder, missing, set);
  TellUnused(folder.string(), unused);
  return set;
}

Dataset ReadTransforms(const std::filesystem::path& folder, MissingPictures missing) {
  const std::filesystem::path path = folder / "transforms.json";
  const nlohmann::json file = ReadJson(path);
  const CheckedJson json(file, path);
  Unused unused;
  std::vector<Frame> frames = ReadFrames(json, path, unused);
  Dataset set;
  for (const SplitList& list : kSplitLists) set.has_split |= json.Has(list.name);
  if (set.has_split) ApplySplitLists(json, path, frames);
  FileOfName files;
  for (const Frame& frame : frames) AddPicture(frame.picture, path, files, set);
  const bool has_training =
      std::any_of(set.pictures.begin(), set.pictures.end(),
                  [](const PosedPicture& picture) { return picture.split == Split::kTrain; });
  if (!has_training) {
    throw DataError(fmt::format("{}: frames has no training view; expected some", path.string()));
  }
  HandleMissingFrames(folder, missing, set);
  set.box_in_input = ReadBox(json);
  ReadPoints(json, folder, set);
  TellUnused(path.string(), unused);
  return set;
}

}  // namespace tetrec
