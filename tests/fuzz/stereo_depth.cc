// Fuzz target: depth maps. What is read must be valid enough to be used pixel by pixel.
#include "run/stereo_depth.h"

#include "fuzz/fuzz_target.h"

#include <cstdlib>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  return fuzz::Refusing([&] {
    const tetrec::StereoDepth map = tetrec::ParseStereoDepth({data, size}, "fuzz.depth");
    for (int y = 0; y < map.camera.height; ++y) {
      for (int x = 0; x < map.camera.width; ++x) {
        if (!(map.depth.at(map.Index(x, y)) >= 0)) std::abort();
      }
    }
  });
}
