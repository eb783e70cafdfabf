// Fuzz target: tet mesh files. What is read must be valid enough to measure and to write.
#include "mesh/tet_mesh.h"

#include "fuzz/fuzz_target.h"

#include <cmath>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  return fuzz::Refusing([&] {
    tetrec::TetMesh mesh = tetrec::ParseTetMesh({data, size}, "fuzz.tet");
    tetrec::MeasureQuality(mesh);
    tetrec::SortAlongMortonCurve(mesh);
    tetrec::CheckTetMesh(mesh);
  });
}
