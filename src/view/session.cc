// The scene, the field that is shown, and when it is replaced.
#include "view/session.h"

#include "core/error.h"
#include "core/log.h"
#include "core/stop_request.h"

#include <cmath>
#include <numbers>

namespace tetrec {
namespace {

using nlohmann::json;

json ArrayOf(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

glm::dvec3 AxisOf(const Rigid3& cam_from_world, int axis) {
  return glm::transpose(cam_from_world.rotation)[axis];
}

json DescribeView(const View& view, const Camera& camera) {
  const double fov = 2 * std::atan(0.5 * camera.height / camera.fy) * 180 / std::numbers::pi;
  return {{"name", view.name},
          {"split", Name(view.split)},
          {"eye", ArrayOf(view.cam_from_world.Inverse().translation)},
          {"forward", ArrayOf(AxisOf(view.cam_from_world, 2))},
          {"up", ArrayOf(-AxisOf(view.cam_from_world, 1))},
          {"fov", fov},
          {"width", camera.width},
          {"height", camera.height}};
}

json StatusOf(const FieldFile& file, const ShownField& shown, int loaded) {
  return {{"field", Describe(file)},
          {"loaded", loaded},
          {"tets", shown.field.mesh.tets.size()},
          {"vertices", shown.field.mesh.positions.size()},
          {"problem", ""}};
}

}  // namespace

ViewSession::ViewSession(const std::filesystem::path& run, const RendererOptions& options)
    : run_(FindRun(run)),
      options_(options),
      shown_scene_{run_.scene, ReadScene(run_.scene)},
      file_(NewestField(run_)),
      shown_(MakeShownField(ReadFieldFile(file_, scene()), options_)),
      status_(StatusOf(file_, shown_, 1)) {
  if (scene().views.empty()) throw DataError(run_.scene.string() + ": the scene has no views");
  LogInfo("shows {}: {}", file_.path.string(), Describe(file_));
}

std::optional<Image> ViewSession::Draw(const PictureRequest& request) {
  if (request.is_draft) ++waiting_drafts_;
  const std::lock_guard lock(drawing_);
  if (request.is_draft) --waiting_drafts_;
  return Paint(shown_, shown_scene_, request,
               [&] { return StopRequested() || (!request.is_draft && waiting_drafts_ > 0); });
}

void ViewSession::Refresh() {
  try {
    const FieldFile newest = NewestField(run_);
    if (newest == file_) return;
    file_ = newest;
    ShownField shown = MakeShownField(ReadFieldFile(newest, scene()), options_);
    const std::scoped_lock lock(drawing_, facts_);
    shown_ = std::move(shown);
    status_ = StatusOf(newest, shown_, status_["loaded"].get<int>() + 1);
    LogInfo("shows {}: {}", newest.path.string(), Describe(newest));
  } catch (const Error& error) {
    const std::lock_guard lock(facts_);
    status_["problem"] = OneLine(error.what());
  }
}

json ViewSession::Status() const {
  const std::lock_guard lock(facts_);
  return status_;
}

json ViewSession::DescribeScene() const {
  const glm::dvec3 size = scene().subject_bounds.Size();
  json views = json::array();
  for (const View& view : scene().views) {
    views.push_back(DescribeView(view, scene().cameras[size_t(view.camera)]));
  }
  return {{"subject",
           {{"center", ArrayOf(scene().subject_bounds.Center())},
            {"size", std::max({size.x, size.y, size.z})}}},
          {"views", std::move(views)}};
}

}  // namespace tetrec
