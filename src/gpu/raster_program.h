// A graphics pipeline without attachments: all that its fragments leave goes into buffers.
#pragma once

#include "gpu/program.h"

namespace tetrec {

// Draws lists of triangles, both sides, without vertex buffers; CommandRecorder::Draw runs it. Both
// stages see all bindings and the push constants; only the fragment stage may write.
// Throws EnvironmentError where the device cannot rasterise.
Program MakeRasterProgram(const Device& device, std::string name,
                          std::span<const uint32_t> vertex_spirv,
                          std::span<const uint32_t> fragment_spirv,
                          std::vector<BindingSpec> bindings, uint32_t push_bytes);

}  // namespace tetrec
