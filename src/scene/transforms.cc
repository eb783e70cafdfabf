// Readers of transforms JSON files.
#include "scene/transforms.h"

#include "core/error.h"
#include "core/file.h"
#include "geometry/rotation.h"
#include "scene/checked_json.h"

#include <fmt/format.h>

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
// The files hold floats (1e-7); some writers print six digits.
constexpr double kRotationTolerance = 1e-4;
constexpr double kFarthestCamera = 1e9;

Rigid3 CamFromInput(const CheckedJson& json) {
  if (json.Size() != 4) json.Fail(fmt::format("has {} rows; expected 4", json.Size()));
  double rows[4][4];
  for (size_t i = 0; i < 4; ++i) {
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

// The picture that "file_path" means: as written, else with .png.
std::filesystem::path FindPicture(const std::filesystem::path& folder,
                                  const std::filesystem::path& relative, const CheckedJson& json) {
  std::error_code unusable;  // e.g. a name too long for the file system: not there either
  const std::filesystem::path as_written = folder / relative;
  if (std::filesystem::is_regular_file(as_written, unusable)) return as_written;
  const std::filesystem::path with_png = as_written.string() + ".png";
  if (std::filesystem::is_regular_file(with_png, unusable)) return with_png;
  json.Fail(fmt::format("names a missing picture: neither {} nor {} is there", as_written.string(),
                        with_png.string()));
}

PosedPicture ReadFrame(const CheckedJson& json, const std::filesystem::path& folder) {
  const CheckedJson file_path = json.Field("file_path");
  const std::filesystem::path relative = std::filesystem::path(file_path.Text()).lexically_normal();
  if (!StaysInside(relative)) {
    file_path.Fail(
        fmt::format("is \"{}\"; expected a path inside {}", relative.string(), folder.string()));
  }
  PosedPicture picture;
  picture.file = FindPicture(folder, relative, file_path);
  const bool has_extension = picture.file == folder / relative;
  picture.name = (has_extension ? std::filesystem::path(relative).replace_extension() : relative)
                     .generic_string();
  picture.cam_from_input = CamFromInput(json.Field("transform_matrix"));
  return picture;
}

std::vector<PosedPicture> ReadSplit(const std::filesystem::path& path, Split split) {
  const nlohmann::json file = ReadJson(path);
  const CheckedJson json(file, path);
  const CheckedJson angle = json.Field("camera_angle_x");
  const double fov_rad = angle.Number();
  if (fov_rad < kMinFov_rad || fov_rad > kMaxFov_rad) {
    angle.Fail(fmt::format("is {}; expected the horizontal field of view, {} to {} radians",
                           fov_rad, kMinFov_rad, kMaxFov_rad));
  }
  const CheckedJson frames = json.Field("frames");
  std::vector<PosedPicture> pictures(frames.Size());
  for (size_t i = 0; i < pictures.size(); ++i) {
    pictures[i] = ReadFrame(frames.Item(i), path.parent_path());
    pictures[i].split = split;
    pictures[i].horizontal_fov_rad = fov_rad;
  }
  return pictures;
}

}  // namespace

Dataset ReadNerfSynthetic(const std::filesystem::path& folder) {
  if (!std::filesystem::is_directory(folder)) {
    throw DataError(
        fmt::format("{}: no such folder; expected a NeRF-synthetic data set", folder.string()));
  }
  Dataset set;
  set.has_split = true;
  std::unordered_map<std::string, const char*> file_of_name;
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
    for (PosedPicture& picture : ReadSplit(path, split_file.split)) {
      const auto [other, is_new] = file_of_name.emplace(picture.name, split_file.name);
      if (!is_new) {
        throw DataError(
            fmt::format("{}: picture \"{}\" of {} is in {} already; a view may be listed "
                        "once",
                        folder.string(), picture.name, split_file.name, other->second));
      }
      set.pictures.push_back(std::move(picture));
    }
    if (split_file.split == Split::kTrain && set.pictures.empty()) {
      throw DataError(fmt::format("{}: frames is empty; expected training views", path.string()));
    }
  }
  return set;
}

Dataset ReadTransforms(const std::filesystem::path& folder) {
  Dataset set;
  set.pictures = ReadSplit(folder / "transforms.json", Split::kTrain);
  return set;
}

}  // namespace tetrec
