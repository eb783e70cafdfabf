// Fuzz target: COLMAP's text models. The first byte selects the file: 0 cameras.txt, 1 images.txt,
// 2 points3D.txt. The other two are valid, so that references between the files are tested too.
#include "colmap/text.h"
#include "fuzz/fuzz_target.h"

#include <array>
#include <string_view>

namespace {

// One camera, two images, one point that both see.
constexpr std::array<std::string_view, 3> kValid = {
    "1 PINHOLE 40 30 50 50 20 15\n",
    "1 1 0 0 0 0.1 0 4 1 p1\n20 15 1\n2 1 0 0 0 0.2 0 4 1 p2\n20 15 1\n",
    "1 0 0 3 1 2 3 0.5 1 0 2 0\n"};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  std::array<std::string_view, 3> files = kValid;
  files[data[0] % 3] = {reinterpret_cast<const char*>(data) + 1, size - 1};
  return fuzz::Refusing([&] {
    const tetrec::ColmapModel model{tetrec::ParseColmapCamerasText(files[0], "cameras.txt"),
                                    tetrec::ParseColmapImagesText(files[1], "images.txt"),
                                    tetrec::ParseColmapPointsText(files[2], "points3D.txt")};
    tetrec::CheckColmapModel(model, "fuzzed");
  });
}
