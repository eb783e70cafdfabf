// Fuzz target: headers of volumes. The first byte says what the rest is: .nrrd, .nhdr, .mha or
// .mhd; beside it lies data.raw, 24 bytes.
#include "fuzz/fuzz_target.h"
#include "scene/volume_io.h"

#include <array>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const fuzz::Folder folder;
  static const bool prepared = [] {
    folder.Write("data.raw", std::array<uint8_t, 24>{1, 2, 3});
    return true;
  }();
  if (!prepared || size == 0) return 0;
  constexpr const char* kNames[] = {"volume.nrrd", "volume.nhdr", "volume.mha", "volume.mhd"};
  const std::filesystem::path path = folder.path() / kNames[data[0] % 4];
  return fuzz::Refusing([&] { tetrec::ParseVolume({data + 1, data + size}, path); });
}
