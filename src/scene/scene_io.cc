// The scene folder on disk: scene.json (schema 1) and points.ply.
#include "core/error.h"
#include "core/file.h"
#include "geometry/checked_geometry.h"
#include "scene/points.h"
#include "scene/scene.h"

#include <fmt/format.h>

#include <unordered_set>

namespace tetrec {
namespace {

constexpr int kSchema = 1;
constexpr int kMaxSide_px = 1 << 16;
// Rotations are written with 17 digits, so anything less accurate was not written by Tetrec.
constexpr double kRotationTolerance = 1e-6;
constexpr const char* kPointsFile = "points.ply";

// The enumeration value with the name in `json`.
template <class E>
E ReadWord(const CheckedJson& json) {
  const std::string name = json.Text();
  const std::optional<E> value = FromName<E>(name);
  if (!value) json.Fail(fmt::format("is \"{}\"; expected {}", name, AllNames<E>()));
  return *value;
}

using tetrec::ToJson;  // the overloads in this file would hide it

nlohmann::json ToJson(const Rigid3& transform) {
  return {{"rotation", ToJson(transform.rotation)}, {"translation", ToJson(transform.translation)}};
}

glm::dmat3 ReadRotation(const CheckedJson& json) {
  return CheckedRotation(json.Matrix3(), kRotationTolerance, json);
}

Rigid3 ReadRigid(const CheckedJson& json) {
  return {ReadRotation(json.Field("rotation")), json.Field("translation").Vector3()};
}

nlohmann::json ToJson(const Camera& camera) {
  return {{"width", camera.width}, {"height", camera.height}, {"fx", camera.fx},
          {"fy", camera.fy},       {"cx", camera.cx},         {"cy", camera.cy}};
}

Camera ReadCamera(const CheckedJson& json) {
  Camera camera;
  camera.width = int(json.Field("width").IntegerIn(1, kMaxSide_px));
  camera.height = int(json.Field("height").IntegerIn(1, kMaxSide_px));
  camera.fx = json.Field("fx").NumberIn(1e-3, 1e9);
  camera.fy = json.Field("fy").NumberIn(1e-3, 1e9);
  camera.cx = json.Field("cx").NumberIn(-1e9, 1e9);
  camera.cy = json.Field("cy").NumberIn(-1e9, 1e9);
  return camera;
}

nlohmann::json ToJson(const View& view) {
  return {{"name", view.name},
          {"image", view.image},
          {"camera", view.camera},
          {"split", Name(view.split)},
          {"cam_from_world", ToJson(view.cam_from_world)}};
}

View ReadView(const CheckedJson& json, size_t camera_count) {
  View view;
  view.name = json.Field("name").Text();
  view.image = json.Field("image").Text();
  view.camera = int(json.Field("camera").IntegerIn(0, int64_t(camera_count) - 1));
  view.split = ReadWord<Split>(json.Field("split"));
  view.cam_from_world = ReadRigid(json.Field("cam_from_world"));
  // Later stages name their files after views.
  if (!StaysInside(view.name)) {
    json.Field("name").Fail(fmt::format("is \"{}\"; expected a relative path", view.name));
  }
  if (!StaysInside(view.image)) {
    json.Field("image").Fail(fmt::format("is \"{}\", which leaves the scene folder", view.image));
  }
  return view;
}

// Everything except the points; accesses no other file.
Scene SceneFromJson(const CheckedJson& json) {
  json.Field("schema").IntegerIn(kSchema, kSchema);
  Scene scene;
  scene.background = ReadWord<Background>(json.Field("background"));
  scene.has_alpha = json.Field("has_alpha").Flag();
  // Scenes written by earlier versions lack this field.
  scene.has_masks = json.Has("has_masks") && json.Field("has_masks").Flag();
  if (scene.has_alpha && scene.has_masks) {
    json.Field("has_masks")
        .Fail("is true although has_alpha is; alpha has only one of the two meanings");
  }
  scene.subject_bounds = ReadBounds(json.Field("subject_bounds"));
  scene.input_from_world = ReadSimilarity(json.Field("input_from_world"), kRotationTolerance);
  const CheckedJson cameras = json.Field("cameras");
  if (cameras.Size() == 0) cameras.Fail("is empty; expected at least one camera");
  for (size_t i = 0; i < cameras.Size(); ++i) scene.cameras.push_back(ReadCamera(cameras.Item(i)));

  const CheckedJson views = json.Field("views");
  std::unordered_set<std::string> names;
  for (size_t i = 0; i < views.Size(); ++i) {
    scene.views.push_back(ReadView(views.Item(i), scene.cameras.size()));
    const std::string& name = scene.views.back().name;
    if (!names.insert(name).second) {
      views.Item(i).Field("name").Fail(fmt::format("\"{}\" names an earlier view too", name));
    }
  }
  if (scene.views.empty()) views.Fail("is empty; expected at least one view");
  return scene;
}

}  // namespace

std::vector<int> Scene::ViewsOf(Split split) const {
  std::vector<int> indices;
  for (size_t i = 0; i < views.size(); ++i) {
    if (views[i].split == split) indices.push_back(int(i));
  }
  return indices;
}

std::vector<int> Scene::HeldOutViews() const {
  std::vector<int> test = ViewsOf(Split::kTest);
  return test.empty() ? ViewsOf(Split::kValidation) : test;
}

Scene ReadScene(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / "scene.json";
  const nlohmann::json file = ReadJson(path);
  const CheckedJson json(file, path);
  Scene scene = SceneFromJson(json);
  for (size_t i = 0; i < scene.views.size(); ++i) {
    const std::filesystem::path image = folder / scene.views[i].image;
    std::error_code
        unusable;  // such as a name too long for the file system, which does not exist either
    if (!std::filesystem::is_regular_file(image, unusable)) {
      json.Field("views").Item(i).Field("image").Fail(
          fmt::format("is missing: {}; run the stage that wrote the scene again", image.string()));
    }
  }
  const uint64_t point_count = uint64_t(json.Field("point_count").IntegerIn(0, int64_t{1} << 40));
  if (point_count == 0) return scene;
  scene.points = ReadScenePoints(folder / kPointsFile);
  if (scene.points.size() != point_count) {
    throw DataError(fmt::format("{}: has {} points, but scene.json states {}",
                                (folder / kPointsFile).string(), scene.points.size(), point_count));
  }
  return scene;
}

void WriteScene(const std::filesystem::path& folder, const Scene& scene) {
  nlohmann::json cameras = nlohmann::json::array(), views = nlohmann::json::array();
  for (const Camera& camera : scene.cameras) cameras.push_back(ToJson(camera));
  for (const View& view : scene.views) views.push_back(ToJson(view));
  const nlohmann::json file = {{"schema", kSchema},
                               {"background", Name(scene.background)},
                               {"has_alpha", scene.has_alpha},
                               {"has_masks", scene.has_masks},
                               {"subject_bounds", ToJson(scene.subject_bounds)},
                               {"input_from_world", ToJson(scene.input_from_world)},
                               {"cameras", cameras},
                               {"views", views},
                               {"point_count", scene.points.size()}};
  SceneFromJson(CheckedJson(file, folder / "scene.json"));  // refuses what could not be read again
  std::filesystem::create_directories(folder);
  if (!scene.points.empty()) {
    WriteScenePoints(folder / kPointsFile, scene.points);
  } else {
    std::filesystem::remove(folder / kPointsFile);
  }
  WriteJson(folder / "scene.json", file);
}

}  // namespace tetrec
