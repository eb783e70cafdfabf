// What a kernel's SPIR-V declares: bindings and how it uses them, push constants, local size,
// specialization constants. The host binds buffers by these facts, so nothing is written twice.
//
// SPIRV-Cross (packaged as libspirv-cross-c-shared) finds the same facts, but it is a compiler of
// some megabytes that rebuilds the whole program first; five facts of trusted, embedded modules
// need one pass over their words.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace tetrec {

// How a kernel uses a binding; the command recorder derives barriers from it. A storage buffer that
// is declared neither `readonly` nor `writeonly` is kReadWrite.
enum class Access { kTexelRead, kRead, kWrite, kReadWrite };

inline bool Writes(Access access) {
  return access == Access::kWrite || access == Access::kReadWrite;
}

struct KernelBinding {
  uint32_t number;  // kBind... in shaders/shared/gpu_types.glsl.h
  Access access;
  // The kernel's code refers to it. Variants of a kernel may declare more than they use: only what
  // is used belongs to the pipeline layout.
  bool is_used;
  std::string name;  // of the block or the texel buffer; empty if the debug names are stripped
};

struct Reflection {
  std::vector<KernelBinding> bindings;   // by number, all of descriptor set 0
  uint32_t push_bytes = 0;               // up to the end of the last push constant
  std::array<uint32_t, 3> local_size{};  // 0 unless it is a compute kernel
  std::vector<uint32_t> constant_ids;    // of specialization constants, ascending
};

// Throws BugError("<name>: ...") if the words are not a SPIR-V module with one entry point or use
// resources other than storage buffers, uniform texel buffers and push constants.
Reflection Reflect(const std::string& name, std::span<const uint32_t> spirv);

// What two stages of one pipeline declare together.
Reflection Merge(const std::string& name, const Reflection& a, const Reflection& b);

}  // namespace tetrec
