// A graphics pipeline without attachments: its fragments write only to buffers.
#pragma once

#include "gpu/program.h"

namespace tetrec {

// Draws lists of triangles, both sides, without vertex buffers; CommandRecorder::Draw runs it. Both
// stages see all bindings and the push constants; only the fragment stage may write.
// Throws EnvironmentError if the device cannot rasterise.
Program MakeRasterProgram(const Device& device, std::string name,
                          std::span<const uint32_t> vertex_spirv,
                          std::span<const uint32_t> fragment_spirv);

}  // namespace tetrec
