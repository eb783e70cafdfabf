// Readers of transforms JSON files.
#include "import/transforms.h"

#include "core/checked_json.h"
#include "core/error.h"
#include "core/file.h"
#include "core/log.h"
#include "core/short_list.h"
#include "geometry/rotation.h"
#include "image/file_names.h"
#include "import/image_folders.h"
#include "import/missing_pictures.h"
#include "import/transforms_lens.h"
#include "scene/points.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
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

// The files contain floats (1e-7), some of them printed with six digits.
constexpr double kRotationTolerance = 1e-4;
constexpr double kFarthestCamera = 1e9;

// Extensions to try, in this order, for a file path that names no file.
constexpr const char* kExtensions[] = {".png", ".jpg", ".jpeg", ".PNG", ".JPG", ".JPEG", ".exr"};

// The fields, besides those of lenses, that are read or refused by name; others are listed as
// unused.
const std::set<std::string> kFileFields = {"frames",           "aabb",
                                           "aabb_scale",       "scale",
                                           "offset",           "ply_file_path",
                                           "train_filenames",  "val_filenames",
                                           "test_filenames",   "normal_mts_args",
                                           "from_na",          "white_transparent",
                                           "black_transparent"};
const std::set<std::string> kFrameFields = {"file_path", "transform_matrix", "mask_path",
                                            "depth_file_path", "depth_path"};

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
  if (!affine) json.Item(3).Fail("is not 0 0 0 1, so the matrix is not a pose");
  Rigid3 input_from_opengl;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) input_from_opengl.rotation[j][i] = rows[i][j];
    input_from_opengl.translation[i] = rows[i][3];
  }
  const double distance = DistanceFromRotation(input_from_opengl.rotation);
  if (!(distance <= kRotationTolerance)) {
    json.Fail(fmt::format(
        "is not a rigid pose: R^T R is off by {:.2g}, more than the {:.2g} that rounding explains; "
        "the axes are scaled or mirrored, or the numbers have fewer than six digits",
        distance, kRotationTolerance));
  }
  input_from_opengl.rotation = NearestRotation(input_from_opengl.rotation);
  const Rigid3 cam_from_opengl{glm::dmat3(1, 0, 0, 0, -1, 0, 0, 0, -1), glm::dvec3(0.0)};
  return cam_from_opengl * input_from_opengl.Inverse();
}

// The normalised path that a field names, relative to the folder.
std::filesystem::path PathInside(const CheckedJson& json, const std::filesystem::path& folder) {
  std::string text = json.Text();
  std::replace(text.begin(), text.end(), '\\', '/');  // the separators of Windows
  const std::filesystem::path relative = std::filesystem::path(text).lexically_normal();
  if (!StaysInside(relative)) {
    json.Fail(
        fmt::format("is \"{}\"; expected a path inside {}", relative.string(), folder.string()));
  }
  return relative;
}

bool IsFile(const std::filesystem::path& path) {
  std::error_code
      unusable;  // such as a name too long for the file system, which does not exist either
  return std::filesystem::is_regular_file(path, unusable);
}

// The image that "file_path" means: as written, or else with an extension; empty if neither exists.
std::filesystem::path FindPicture(const std::filesystem::path& as_written) {
  if (IsFile(as_written)) return as_written;
  for (const char* extension : kExtensions) {
    const std::filesystem::path extended = as_written.string() + extension;
    if (IsFile(extended)) return extended;
  }
  return {};
}

// What instant-ngp or nerfstudio may use but this reader ignores, gathered over the files of a data
// set.
struct Unused {
  std::set<std::string> fields;
  std::set<std::string> transparencies;
  size_t depths = 0, alphas = 0, dynamic_masks = 0, rays = 0;
};

// Names come from untrusted files and go into the log.
std::string Shown(std::string name) {
  constexpr size_t kLongest = 60;
  if (name.size() > kLongest) name = name.substr(0, kLongest) + "...";
  std::replace_if(
      name.begin(), name.end(), [](char c) { return uint8_t(c) < 0x20 || c == 0x7F; }, '?');
  return name;
}

// If each row of pixels has its own pose, no single pose is right.
void RefuseRollingShutter(const CheckedJson& json) {
  if (!json.Has("rolling_shutter")) return;
  const CheckedJson times = json.Field("rolling_shutter");
  bool is_off = times.IsArray() || times.IsOff();
  for (size_t i = 0; times.IsArray() && i < times.Size(); ++i) {
    is_off = is_off && times.Item(i).Number() == 0;
  }
  if (!is_off) {
    times.Fail(
        "is not 0: images whose rows were taken one after the other are not supported; rectify "
        "them "
        "and set rolling_shutter to 0");
  }
}

// instant-ngp's marks for poses along axes other than OpenGL's.
void RefuseOtherAxes(const CheckedJson& json) {
  for (const char* mark : {"normal_mts_args", "from_na"}) {
    if (!json.Has(mark) || json.Field(mark).IsOff()) continue;
    json.Field(mark).Fail(
        "means that the poses follow axes other than OpenGL's (x right, y up, z back), which are "
        "not supported; convert them and remove this field");
  }
}

void NoteFieldsOfFile(const CheckedJson& json, Unused& unused) {
  for (const std::string& name : json.Names()) {
    if (!internal::IsLensField(name) && !kFileFields.contains(name))
      unused.fields.insert(Shown(name));
  }
  for (const char* flag : {"white_transparent", "black_transparent"}) {
    if (json.Has(flag) && !json.Field(flag).IsOff()) unused.transparencies.insert(flag);
  }
}

void NoteFieldsOfFrame(const CheckedJson& json, Unused& unused) {
  for (const std::string& name : json.Names()) {
    if (!internal::IsLensField(name) && !kFrameFields.contains(name)) {
      unused.fields.insert("frames[]." + Shown(name));
    }
  }
  unused.depths += json.Has("depth_file_path") || json.Has("depth_path");
}

// Notes the files beside an image that instant-ngp would read.
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

// Reports once per data set.
void LogUnused(const std::string& name, const Unused& unused) {
  const auto warn = [&](size_t count, const char* what) {
    if (count > 0) LogWarning("{}: {}: {}; not used", name, what, count);
  };
  warn(unused.alphas, "images with their alpha in a separate file (NAME.alpha.png)");
  warn(unused.dynamic_masks, "images with a separate mask of what moves (dynamic_mask_NAME)");
  warn(unused.rays, "images with their pixels' rays in a separate file (rays_NAME.dat)");
  if (!unused.transparencies.empty()) {
    LogWarning("{}: {} is not used: colours stay as they are; give the images alpha", name,
               fmt::join(unused.transparencies, ", "));
  }
  if (unused.depths > 0) {
    LogInfo("{}: depth images named by frames: {}; not used", name, unused.depths);
  }
  if (!unused.fields.empty()) {
    constexpr size_t kMost = 50;
    const std::vector<std::string> fields(unused.fields.begin(), unused.fields.end());
    LogInfo("{}: unused fields: {}", name, ShortList(fields, kMost));
  }
}

// The path without its first folder.
std::filesystem::path WithoutFolder(const std::filesystem::path& path) {
  std::filesystem::path rest;
  for (auto part = std::next(path.begin()); part != path.end(); ++part) rest /= *part;
  return rest.empty() ? path : rest;
}

// The picture of a frame and its normalised file_path.
struct Frame {
  PosedPicture picture;
  std::filesystem::path relative;
};

// A missing image has an empty file. Whether its mask exists matters only when masks are used.
Frame ReadFrame(const internal::FrameFields& fields, const std::filesystem::path& folder,
                const std::string& images, Unused& unused) {
  const CheckedJson& json = fields.frame;
  Frame frame;
  frame.relative = PathInside(json.Field("file_path"), folder);
  RefuseRollingShutter(json);
  NoteFieldsOfFrame(json, unused);
  PosedPicture& picture = frame.picture;
  const std::filesystem::path as_written =
      folder / (images.empty() ? frame.relative : images / WithoutFolder(frame.relative));
  picture.file = FindPicture(as_written);
  if (!picture.file.empty()) NoteFilesBeside(picture.file, as_written, unused);
  picture.name = frame.relative.generic_string();
  if (picture.file == as_written) picture.name = WithoutImageExtension(picture.name);
  picture.cam_from_input = CamFromInput(json.Field("transform_matrix"));
  if (json.Has("mask_path")) {
    picture.mask = folder / PathInside(json.Field("mask_path"), folder);
  }
  if (fields.Has("w") || fields.Has("h")) {
    picture.lens = internal::ReadLens(fields);
  } else {
    internal::ReadFieldOfView(fields, picture);
  }
  return frame;
}

std::vector<Frame> ReadFrames(const CheckedJson& json, const std::filesystem::path& path,
                              const std::string& images, Unused& unused) {
  RefuseRollingShutter(json);
  RefuseOtherAxes(json);
  NoteFieldsOfFile(json, unused);
  const CheckedJson items = json.Field("frames");
  std::vector<Frame> frames;
  for (size_t i = 0; i < items.Size(); ++i) {
    frames.push_back(ReadFrame({items.Item(i), json}, path.parent_path(), images, unused));
  }
  return frames;
}

// What to do about images that are missing, besides what is done about those of any data set.
std::string AdviceOnMissing(const std::filesystem::path& folder, const DatasetReading& reading,
                            const Dataset& set) {
  if (!reading.images.empty()) return "; leave out --images to read those that frames name";
  const auto missing =
      std::find_if(set.pictures.begin(), set.pictures.end(),
                   [](const PosedPicture& picture) { return picture.file.empty(); });
  if (missing == set.pictures.end()) return {};
  const std::filesystem::path image = missing->name;
  return AdviceOnCopies(FindReducedCopies(folder / *image.begin(), WithoutFolder(image)));
}

void HandleMissingFrames(const std::filesystem::path& folder, const DatasetReading& reading,
                         Dataset& set) {
  HandleMissingPictures(
      folder, reading.missing, set,
      {.tried = fmt::format(", both as written and with {}",
                            fmt::join(std::begin(kExtensions), std::end(kExtensions), ", ")),
       .advice = AdviceOnMissing(folder, reading, set)});
}

// The JSON file that lists an image, and the image's place among the pictures.
struct Listed {
  std::string json_file;
  size_t picture = 0;
};
// By the image's file (its name if that is missing).
using ListedImages = std::unordered_map<std::string, Listed>;

// A view may be listed once; but where the views for validation are among those for test, as some
// programs write them, they are test views.
void AddPicture(const PosedPicture& picture, const std::filesystem::path& path,
                ListedImages& listed, Dataset& set) {
  const std::string json_file = path.filename().string();
  const std::string image = picture.file.empty() ? picture.name : picture.file.string();
  const auto [other, is_new] = listed.emplace(image, Listed{json_file, set.pictures.size()});
  if (is_new) {
    set.pictures.push_back(picture);
    return;
  }
  PosedPicture& earlier = set.pictures[other->second.picture];
  const bool becomes_test = earlier.split == Split::kValidation && picture.split == Split::kTest &&
                            other->second.json_file != json_file;
  if (!becomes_test) {
    // Some programs write the training views once more, so that the file exists.
    const bool is_copy = picture.split == Split::kTest && earlier.split == Split::kTrain;
    throw DataError(fmt::format(
        "{}: image \"{}\" of {} is in {} already; a view may be listed only once{}",
        path.parent_path().string(), picture.name, json_file, other->second.json_file,
        is_copy ? fmt::format("; remove {} to hold out every 8th view", json_file) : ""));
  }
  earlier = picture;
  other->second.json_file = json_file;
}

// If some images differ only in their extensions, all names keep them.
void MakeNamesUnique(const std::filesystem::path& folder, Dataset& set) {
  std::set<std::string> names;
  for (const PosedPicture& picture : set.pictures) names.insert(picture.name);
  if (names.size() == set.pictures.size()) return;
  for (PosedPicture& picture : set.pictures) {
    if (picture.file.empty()) continue;
    picture.name = picture.file.lexically_relative(folder).generic_string();
  }
}

// transforms.json may have a list of file paths for each split.
struct SplitList {
  const char* name;
  Split split;
};
constexpr SplitList kSplitLists[] = {{"train_filenames", Split::kTrain},
                                     {"val_filenames", Split::kValidation},
                                     {"test_filenames", Split::kTest}};

// The split in which each file path is listed. Some programs list the same views for validation and
// test; these become test views.
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
        item.Fail(fmt::format("is \"{}\", which no frame names", path.string()));
      const auto [other, is_new] = splits.emplace(path, list.split);
      if (is_new || other->second == list.split) continue;
      if (other->second == Split::kTrain) {
        item.Fail(fmt::format("is \"{}\", which is also in train_filenames", path.string()));
      }
      other->second = list.split;
    }
  }
  return splits;
}

// Sets the splits; removes the frames that are in no list.
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

// instant-ngp maps the input to input * scale + offset, with its box around 0.5. (It then permutes
// the axes cyclically, which does not move a cube around (0.5, 0.5, 0.5).)
std::optional<Bounds3> ReadBox(const CheckedJson& json) {
  if (json.Has("aabb")) {
    const CheckedJson aabb = json.Field("aabb");
    if (aabb.Size() != 2) aabb.Fail(fmt::format("has {} items; expected 2 corners", aabb.Size()));
    const Bounds3 box{aabb.Item(0).Vector3(), aabb.Item(1).Vector3()};
    if (!glm::all(glm::lessThan(box.min, box.max)))
      aabb.Fail("is not a box from minimum to maximum");
    return box;
  }
  if (!json.Has("aabb_scale")) return std::nullopt;
  const double side = json.Field("aabb_scale").NumberIn(1e-3, 1e6);
  const double scale = json.Has("scale") ? json.Field("scale").NumberIn(1e-6, 1e6) : 0.33;
  glm::dvec3 offset(0.5);
  if (json.Has("offset")) {
    const CheckedJson field = json.Field("offset");
    offset = field.IsArray() ? field.Vector3() : glm::dvec3(field.Number());
  }
  const glm::dvec3 center = (0.5 - offset) / scale;
  const double half = 0.5 * side / scale;
  return Bounds3{center - half, center + half};
}

constexpr const char* kPointsField = "ply_file_path";

// Data sets are in circulation both with and without this file.
void ReadPoints(const CheckedJson& json, const std::filesystem::path& folder,
                const DatasetReading& reading, Dataset& set) {
  if (!json.Has(kPointsField)) return;
  const std::filesystem::path relative = PathInside(json.Field(kPointsField), folder);
  if (!IsFile(folder / relative)) {
    set.missing_files.push_back(relative.string());
  } else if (reading.points) {
    set.points = ReadColoredPoints(folder / relative);
  } else {
    set.remarks.push_back(PointsNotNeeded((folder / relative).string()));
  }
}

}  // namespace

Dataset ReadNerfSynthetic(const std::filesystem::path& folder, const DatasetReading& reading) {
  if (!std::filesystem::is_directory(folder)) {
    throw DataError(
        fmt::format("{}: no such folder; expected a NeRF-synthetic data set", folder.string()));
  }
  Dataset set;
  set.has_split = true;
  ListedImages listed;
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
    for (Frame& frame : ReadFrames(json, path, reading.images, unused)) {
      frame.picture.split = split_file.split;
      AddPicture(frame.picture, path, listed, set);
    }
    if (split_file.split == Split::kTrain) {
      set.box_in_input = ReadBox(json);
      ReadPoints(json, folder, reading, set);
    }
    if (split_file.split == Split::kTrain && set.pictures.empty()) {
      throw DataError(fmt::format("{}: frames is empty; expected training views", path.string()));
    }
  }
  MakeNamesUnique(folder, set);
  HandleMissingFrames(folder, reading, set);
  LogUnused(folder.string(), unused);
  return set;
}

bool HasMoreThanCameras(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / "transforms.json";
  const nlohmann::json file = ReadJson(path);
  const CheckedJson json(file, path);
  for (const SplitList& list : kSplitLists) {
    if (json.Has(list.name)) return true;
  }
  if (json.Has(kPointsField) && IsFile(folder / PathInside(json.Field(kPointsField), folder)))
    return true;
  const CheckedJson frames = json.Field("frames");
  for (size_t i = 0; i < frames.Size(); ++i) {
    if (frames.Item(i).Has("mask_path")) return true;
  }
  return false;
}

Dataset ReadTransforms(const std::filesystem::path& folder, const DatasetReading& reading) {
  if (!reading.images.empty()) CheckImagesFolder(reading.images);
  const std::filesystem::path path = folder / "transforms.json";
  const nlohmann::json file = ReadJson(path);
  const CheckedJson json(file, path);
  Unused unused;
  std::vector<Frame> frames = ReadFrames(json, path, reading.images, unused);
  Dataset set;
  for (const SplitList& list : kSplitLists) set.has_split |= json.Has(list.name);
  if (set.has_split) ApplySplitLists(json, path, frames);
  ListedImages listed;
  for (const Frame& frame : frames) AddPicture(frame.picture, path, listed, set);
  const bool has_training =
      std::any_of(set.pictures.begin(), set.pictures.end(),
                  [](const PosedPicture& picture) { return picture.split == Split::kTrain; });
  if (!has_training) {
    throw DataError(fmt::format("{}: frames has no training view; expected some", path.string()));
  }
  MakeNamesUnique(folder, set);
  HandleMissingFrames(folder, reading, set);
  set.box_in_input = ReadBox(json);
  ReadPoints(json, folder, reading, set);
  LogUnused(path.string(), unused);
  return set;
}

}  // namespace tetrec
