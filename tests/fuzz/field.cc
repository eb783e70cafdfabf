// Fuzz target: radiance field files.
#include "field/radiance_field.h"
#include "fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  return fuzz::Refusing([&] {
    const tetrec::RadianceField field = tetrec::ParseField({data, size}, "fuzz.tetf");
    tetrec::CheckField(field);
  });
}
