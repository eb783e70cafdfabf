// Fuzz target: the optimiser's checkpoints. The input has no checksum, which no fuzzer would hit:
// it is parsed as it is. What is accepted must be valid enough to become a field, and be the same
// bytes after it was written and read with a checksum.
#include "optimize/checkpoint.h"

#include "core/file.h"
#include "fuzz/fuzz_target.h"

#include <algorithm>
#include <cstdlib>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const fuzz::Folder folder;
  return fuzz::Refusing([&] {
    tetrec::Checkpoint checkpoint = tetrec::ParseCheckpoint({data, size}, "fuzz.bin");
    fuzz::Succeeding([&] {
      const std::filesystem::path path = folder.path() / tetrec::kCheckpointFile;
      tetrec::WriteCheckpoint(path, checkpoint);
      tetrec::ReadCheckpoint(path);
      const std::vector<uint8_t> written = tetrec::ReadBytes(path);
      if (written.size() < size || !std::equal(data, data + size, written.begin())) std::abort();
    });
    tetrec::FieldOf(std::move(checkpoint.mesh), checkpoint.state);
  });
}
