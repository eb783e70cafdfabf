// Fuzz target: PLY files of any kind.
#include "core/ply.h"

#include "fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  return fuzz::Refusing([&] { tetrec::ParsePly({data, size}, "fuzz.ply"); });
}
