// Fuzz target: images and their colour profiles. Only short ones, since the pixels that a longer
// file may claim need more memory than the fuzzer is given.
#include "image/image.h"

#include "fuzz/fuzz_target.h"
#include "image/color_profile.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  constexpr size_t kLongest = 4096;
  if (size > kLongest) return 0;
  return fuzz::Refusing([&] {
    tetrec::Image image = tetrec::DecodeImage({data, size}, "fuzzed");
    tetrec::ApplyColorProfile({data, size}, "fuzzed", image);
  });
}
