// Fuzz target: images. Only short ones, since the pixels that a longer file may claim need more
// memory than the fuzzer is given.
#include "image/image.h"

#include "fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  constexpr size_t kLongest = 4096;
  if (size > kLongest) return 0;
  return fuzz::Refusing([&] { tetrec::DecodeImage({data, size}, "fuzzed"); });
}
