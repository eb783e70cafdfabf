// Fuzz target: transforms.json, or transforms_train.json of a NeRF-synthetic folder if the first
// byte is 'n'. The images and the mask of the seeds exist.
#include "import/transforms.h"

#include "fuzz/fuzz_target.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const fuzz::Folder folder;
  static const bool prepared = [] {
    for (const char* file : {"train/r_0.png", "train/r_1.png", "mask.png"}) folder.Write(file, {});
    return true;
  }();
  if (!prepared || size == 0) return 0;
  const bool is_nerf_synthetic = data[0] == 'n';
  folder.Write(is_nerf_synthetic ? "transforms_train.json" : "transforms.json",
               {data + 1, size - 1});
  return fuzz::Refusing([&] {
    if (is_nerf_synthetic) {
      tetrec::ReadNerfSynthetic(folder.path());
    } else {
      tetrec::ReadTransforms(folder.path());
    }
  });
}
