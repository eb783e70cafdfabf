// Fuzz target: transfer functions of Tetrec and ParaView, and their form prepared for rays.
#include "volume/transfer_function.h"

#include "core/file.h"
#include "fuzz/fuzz_target.h"
#include "volume/shaded_transfer.h"

#include <cstdlib>
#include <string_view>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  return fuzz::Refusing([&] {
    const tetrec::ShadedTransfer shaded(
        tetrec::ParseTransferFunction(tetrec::ParseJson(text, "fuzzed"), "fuzzed", {0, 255}));
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
