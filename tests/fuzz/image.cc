// Fuzz target: pictures. Short ones alone: what a longer one may claim and hold takes more memory
// than the fuzzer is given.
#include "scene/image.h"

#include "fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  constexpr size_t kLongest = 4096;
  if (size > kLongest) return -1;  // not for the corpus
  return fuzz::Refusing([&] { tetrec::DecodeImage({data, size}, "fuzzed"); });
}
