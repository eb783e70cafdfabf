// Fuzz target: transforms_train.json of a NeRF-synthetic folder whose picture train/r_0.png is
// there.
#include "scene/transforms.h"

#include "fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const fuzz::Folder folder;
  static const bool prepared = [] {
    folder.Write("train/r_0.png", {});
    return true;
  }();
  if (!prepared) return 0;
  folder.Write("transforms_train.json", {data, size});
  return fuzz::Refusing([&] { tetrec::ReadNerfSynthetic(folder.path()); });
}
