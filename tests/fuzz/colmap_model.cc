// Fuzz target: COLMAP's binary models. The first byte selects the file: 0 cameras.bin, 1
// images.bin, 2 points3D.bin. The other two are valid, so that references between the files are
// tested too.
#include "colmap/model.h"
#include "fuzz/fuzz_target.h"

#include <array>

namespace {

using Bytes = std::vector<uint8_t>;

template <class... Values>
void Append(Bytes& bytes, const Values&... values) {
  const auto append = [&](const auto& value) {
    const auto* begin = reinterpret_cast<const uint8_t*>(&value);
    bytes.insert(bytes.end(), begin, begin + sizeof(value));
  };
  (append(values), ...);
}

// One PINHOLE camera, two images, one point that both see.
std::array<Bytes, 3> ValidModel() {
  std::array<Bytes, 3> files;
  Append(files[0], uint64_t{1}, uint32_t{1}, 1, uint64_t{40}, uint64_t{30}, 50.0, 50.0, 20.0, 15.0);
  Append(files[1], uint64_t{2});
  for (const uint32_t id : {1u, 2u}) {
    Append(files[1], id, 1.0, 0.0, 0.0, 0.0, 0.1 * id, 0.0, 4.0, uint32_t{1});
    Append(files[1], 'p', static_cast<char>('0' + id), '\0', uint64_t{1}, 20.0, 15.0, uint64_t{1});
  }
  Append(files[2], uint64_t{1}, uint64_t{1}, 0.0, 0.0, 3.0, uint8_t{1}, uint8_t{2}, uint8_t{3}, 0.5,
         uint64_t{2}, 1u, 0u, 2u, 0u);
  return files;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const std::array<Bytes, 3> valid = ValidModel();
  if (size == 0) return 0;
  std::array<std::span<const uint8_t>, 3> files = {valid[0], valid[1], valid[2]};
  files[data[0] % 3] = {data + 1, size - 1};
  return fuzz::Refusing([&] {
    const tetrec::ColmapModel model{tetrec::ParseColmapCameras(files[0], "cameras.bin"),
                                    tetrec::ParseColmapImages(files[1], "images.bin"),
                                    tetrec::ParseColmapPoints(files[2], "points3D.bin")};
    tetrec::CheckColmapModel(model, "fuzzed");
    tetrec::MeanReprojectionError_px(model);
    tetrec::MeanTrackLength(model);
  });
}
