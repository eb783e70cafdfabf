// Fuzz target: transfer functions, ours and ParaView's, and their form for rays.
#include "scene/transfer_function.h"

#include "fuzz/fuzz_target.h"
#include "scene/shaded_transfer.h"

#include <cstdlib>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const fuzz::Folder folder;
  folder.Write("tf.json", {data, size});
  return fuzz::Refusing([&] {
    const tetrec::ShadedTransfer shaded(
        tetrec::ReadTransferFunction(folder.path() / "tf.json", {0, 255}));
    for (int i = 0; i <= 16; ++i) {
      const float sample = float(i) / 16;
      const int piece = shaded.PieceOf(sample);
      const glm::vec3 color = shaded.SrgbAt(piece, sample);
      if (!(color.r >= -1e-6f && color.g >= -1e-6f && color.b <= 1 + 1e-6f)) std::abort();
      const float opacity = shaded.OpacityOffset(piece) + shaded.OpacitySlope(piece) * sample;
      if (opacity != opacity) std::abort();
    }
  });
}
