// The data of the 3-D scene; src/eval/web/scene.js draws them.
#include "eval/report_scene.h"

#include "core/base64.h"
#include "core/file.h"
#include "core/progress.h"
#include "core/spread_choice.h"
#include "eval/html.h"
#include "report_scripts.h"

#include <fmt/format.h>

#include <cmath>
#include <string_view>

namespace tetrec {
namespace {

constexpr size_t kMostPoints = 20'000;
constexpr double kPyramid = 0.08;  // length of a camera's pyramid per distance to the subject

std::string Text(const std::vector<float>& values) { return Base64(BytesOf(values)); }

void Append(std::vector<float>& values, const glm::dvec3& v) {
  for (int axis = 0; axis < 3; ++axis) values.push_back(float(v[axis]));
}

// For each view the centre and the corners of its picture, clockwise from the top left.
std::vector<float> Pyramids(const Scene& scene) {
  std::vector<float> corners;
  const glm::dvec3 subject = scene.subject_bounds.Center();
  for (const View& view : scene.views) {
    const Camera& camera = scene.cameras[size_t(view.camera)];
    const Rigid3 world_from_cam = view.cam_from_world.Inverse();
    const double depth = kPyramid * glm::distance(world_from_cam.translation, subject);
    Append(corners, world_from_cam.translation);
    for (const glm::dvec2 corner :
         {glm::dvec2(0, 0), {camera.width, 0}, {camera.width, camera.height}, {0, camera.height}}) {
      Append(corners, world_from_cam * (depth * camera.CamFromImage(corner)));
    }
  }
  return corners;
}

struct Cloud {
  std::vector<float> positions;
  std::vector<uint8_t> colors_srgb;
};

// At most kMostPoints, evenly from the list.
Cloud SomePoints(const std::vector<ScenePoint>& points) {
  Cloud cloud;
  for (const ScenePoint& point : SpreadChoice<ScenePoint>(points, kMostPoints)) {
    Append(cloud.positions, point.position);
    cloud.colors_srgb.insert(cloud.colors_srgb.end(), point.color_srgb.begin(),
                             point.color_srgb.end());
  }
  return cloud;
}

std::string SceneData(const Scene& scene) {
  std::vector<uint8_t> held_out;
  for (const View& view : scene.views) held_out.push_back(view.split != Split::kTrain);
  const Cloud cloud = SomePoints(scene.points);
  const glm::dvec3 center = scene.subject_bounds.Center();
  return fmt::format(
      " data-cameras=\"{}\" data-held-out=\"{}\" data-points=\"{}\" data-colors=\"{}\""
      " data-up=\"[0,0,1]\" data-center=\"[{},{},{}]\" data-radius=\"{}\"",
      Text(Pyramids(scene)), Base64(held_out), Text(cloud.positions), Base64(cloud.colors_srgb),
      center.x, center.y, center.z, 0.5 * glm::length(scene.subject_bounds.Size()));
}

// A 4 x 4 matrix by columns, as three.js reads it.
std::string MatrixText(const Similarity3& t) {
  std::string text;
  for (int column = 0; column < 3; ++column) {
    const glm::dvec3 c = t.scale * t.rotation[column];
    text += fmt::format("{},{},{},0,", c.x, c.y, c.z);
  }
  return fmt::format("[{}{},{},{},1]", text, t.translation.x, t.translation.y, t.translation.z);
}

std::string Choices(const Scene& scene) {
  std::string options = "<option value=\"\">overview</option>";
  for (size_t i = 0; i < scene.views.size(); ++i) {
    options += fmt::format("<option value=\"{}\">{}</option>", i, EscapeHtml(scene.views[i].name));
  }
  return options;
}

std::string Note(const Scene& scene, const SurfaceModel* surface) {
  std::string note =
      "Drag to turn, or use the arrow keys; + and - (or the wheel, once the scene has the focus) "
      "zoom, Home goes back. Cameras of training photos are blue, held-out ones orange.";
  if (scene.points.size() > kMostPoints) {
    note += fmt::format(" {} of {} points.", WithThousands(kMostPoints),
                        WithThousands(scene.points.size()));
  }
  if (surface && !surface->note.empty()) note += " " + surface->note;
  return EscapeHtml(note);
}

}  // namespace

std::string SceneSection(const std::optional<Scene>& scene, const SurfaceModel* surface) {
  if (!scene) return "";
  const std::string heading = "<h2>Surface, cameras and points</h2>";
  if (std::string_view(kThreeScript).empty()) {
    return heading +
           "<p class=\"note\">There is no 3-D scene: three.js (Debian's package libjs-three) was "
           "missing when Tetrec was built.</p>";
  }
  const bool has_surface = surface && !surface->glb.empty();
  std::string data = SceneData(*scene);
  if (has_surface) {
    data += fmt::format(" data-surface=\"{}\" data-world-from-surface=\"{}\"", Base64(surface->glb),
                        MatrixText(scene->input_from_world.Inverse() * surface->input_from_model));
  }
  return heading +
         fmt::format(
             "<div class=\"scene\" data-state=\"loading\"{}><canvas tabindex=\"0\" role=\"img\" "
             "aria-label=\"surface, cameras and sparse points in 3-D; arrow keys turn, plus and "
             "minus zoom\"></canvas><p role=\"status\">Loading…</p><div class=\"controls\">"
             "<label>Surface <select name=\"look\"{}><option value=\"colors\">colours</option>"
             "<option value=\"clay\">grey clay</option><option value=\"wires\">wires</option>"
             "<option value=\"none\">hidden</option></select></label>"
             "<label><input type=\"checkbox\" name=\"cameras\" checked> cameras</label>"
             "<label><input type=\"checkbox\" name=\"points\"{}> points</label>"
             "<label>Look from <select name=\"from\">{}</select></label>"
             "<button type=\"button\">Reset</button></div></div><p class=\"note\">{}</p>",
             data, has_surface ? "" : " disabled", has_surface ? "" : " checked", Choices(*scene),
             Note(*scene, surface));
}

std::string SceneScript() {
  return std::string_view(kThreeScript).empty() ? "" : std::string(kThreeScript) + kSceneScript;
}

}  // namespace tetrec
