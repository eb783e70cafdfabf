// Fuzz target: scene.json. The image that the seed names exists, and so do two points.
#include "scene/scene.h"

#include "fuzz/fuzz_target.h"

namespace {

constexpr char kPoints[] =
    "ply\nformat ascii 1.0\nelement vertex 2\nproperty double x\nproperty double y\n"
    "property double z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
    "property float reprojection_error\nproperty uint track_length\nend_header\n"
    "0 0 0 1 2 3 0.5 3\n1 0 0 4 5 6 0.25 4\n";

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const fuzz::Folder folder;
  static const bool prepared = [] {
    folder.Write("images/0001.png", {});
    folder.Write("points.ply", {reinterpret_cast<const uint8_t*>(kPoints), sizeof(kPoints) - 1});
    return true;
  }();
  if (!prepared) return 0;
  folder.Write("scene.json", {data, size});
  return fuzz::Refusing([&] { tetrec::ReadScene(folder.path()); });
}
