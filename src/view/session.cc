// The scene and the field that are shown, and when they are replaced.
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

std::shared_ptr<const ShownScene> ReadShownScene(const std::filesystem::path& folder) {
  return std::make_shared<const ShownScene>(ShownScene{folder, ReadScene(folder)});
}

json StatusOf(const FieldFile& file, const ShownField& shown, int loaded, int scenes) {
  return {{"field", Describe(file)},
          {"loaded", loaded},
          {"scene", scenes},
          {"tets", shown.field.mesh.tets.size()},
          {"vertices", shown.field.mesh.positions.size()},
          {"problem", ""}};
}

}  // namespace

ViewSession::ViewSession(const std::filesystem::path& run, const RendererOptions& options)
    : run_(FindRun(run)),
      options_(options),
      shown_from_(NewestSources()),
      tried_(shown_from_),
      shown_scene_(ReadShownScene(run_.scene)),
      shown_(MakeShownField(ReadFieldFile(tried_.field, shown_scene_->scene), options_)),
      status_(StatusOf(tried_.field, shown_, 1, 1)) {
  LogInfo("shows {}: {}", tried_.field.path.string(), Describe(tried_.field));
}

ViewSession::Sources ViewSession::NewestSources() const {
  std::error_code missing;  // which ReadScene reports
  return {NewestField(run_), std::filesystem::last_write_time(run_.scene / "scene.json", missing)};
}

std::optional<Image> ViewSession::Draw(const PictureRequest& request,
                                       const std::shared_ptr<const ShownScene>& asked_of) {
  if (request.is_draft) ++waiting_drafts_;
  const std::lock_guard lock(drawing_);
  if (request.is_draft) --waiting_drafts_;
  if (asked_of != shown_scene_) return std::nullopt;
  return Paint(shown_, *shown_scene_, request,
               [&] { return StopRequested() || (!request.is_draft && waiting_drafts_ > 0); });
}

void ViewSession::Refresh() {
  try {
    const Sources newest = NewestSources();
    if (newest.field == shown_from_.field) {
      const std::lock_guard lock(facts_);
      status_["problem"] = "";
      return;
    }
    if (newest == tried_) return;
    tried_ = newest;
    const bool is_other_scene = newest.scene_written != shown_from_.scene_written;
    const std::shared_ptr<const ShownScene> seen_in =
        is_other_scene ? ReadShownScene(run_.scene) : shown_scene_;
    ShownField shown = MakeShownField(ReadFieldFile(newest.field, seen_in->scene), options_);
    shown_from_ = newest;
    const std::scoped_lock lock(drawing_, facts_);
    shown_scene_ = seen_in;
    shown_ = std::move(shown);
    status_ = StatusOf(newest.field, shown_, status_["loaded"].get<int>() + 1,
                       status_["scene"].get<int>() + (is_other_scene ? 1 : 0));
    LogInfo("shows {}: {}", newest.field.path.string(), Describe(newest.field));
  } catch (const Error& error) {
    const std::lock_guard lock(facts_);
    status_["problem"] = OneLine(error.what());
  }
}

std::shared_ptr<const ShownScene> ViewSession::scene() const {
  const std::lock_guard lock(facts_);
  return shown_scene_;
}

json ViewSession::Status() const {
  const std::lock_guard lock(facts_);
  return status_;
}

json ViewSession::DescribeScene() const {
  const std::lock_guard lock(facts_);
  const Scene& described = shown_scene_->scene;
  const glm::dvec3 size = described.subject_bounds.Size();
  json views = json::array();
  for (const View& view : described.views) {
    views.push_back(DescribeView(view, described.cameras[size_t(view.camera)]));
  }
  return {{"number", status_["scene"]},
          {"subject",
           {{"center", ArrayOf(described.subject_bounds.Center())},
            {"size", std::max({size.x, size.y, size.z})}}},
          {"views", std::move(views)}};
}

}  // namespace tetrec
