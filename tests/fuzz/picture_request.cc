// Fuzz target: the viewer's pictures, as the query of an address. What is accepted must be a camera
// that rays can start from.
#include "view/picture_request.h"

#include "core/error.h"
#include "fuzz/fuzz_target.h"
#include "geometry/rotation.h"

#include <cmath>
#include <cstdlib>
#include <string_view>

namespace {

tetrec::Scene SceneOfOneView() {
  tetrec::Scene scene;
  scene.cameras = {{400, 300, 500, 510, 190, 160}};
  scene.views.resize(1);
  return scene;
}

// "name=value&name=value"; of a name given twice the first counts, as on the server.
std::map<std::string, std::string> QueryOf(std::string_view text) {
  std::map<std::string, std::string> query;
  while (!text.empty()) {
    const std::string_view pair = text.substr(0, text.find('&'));
    const size_t equals = std::min(pair.find('='), pair.size());
    query.emplace(pair.substr(0, equals), pair.substr(std::min(equals + 1, pair.size())));
    text.remove_prefix(std::min(pair.size() + 1, text.size()));
  }
  return query;
}

bool IsPossible(const tetrec::PictureRequest& request) {
  const auto is_side = [](int side) { return side >= 1 && side <= tetrec::kLargestPicture_px; };
  const tetrec::Camera& camera = request.from.camera;
  const tetrec::Rigid3& pose = request.from.cam_from_world;
  return is_side(camera.width) && is_side(camera.height) && camera.fx > 0 && camera.fy > 0 &&
         std::isfinite(camera.fx + camera.fy + camera.cx + camera.cy) &&
         tetrec::DistanceFromRotation(pose.rotation) < 1e-6 &&
         std::isfinite(pose.translation.x + pose.translation.y + pose.translation.z) &&
         request.slice_depth > 0;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const tetrec::Scene scene = SceneOfOneView();
  return fuzz::Refusing<tetrec::UsageError>([&] {
    const std::string_view text(reinterpret_cast<const char*>(data), size);
    if (!IsPossible(tetrec::ParsePictureRequest(QueryOf(text), scene))) std::abort();
  });
}
