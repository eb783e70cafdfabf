// Fuzz target: headers of volumes. The first byte selects the format of the rest: .nrrd, .nhdr,
// .mha or .mhd. A file data.raw of 24 bytes is beside it.
#include "fuzz/fuzz_target.h"
#include "volume/reader.h"

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
