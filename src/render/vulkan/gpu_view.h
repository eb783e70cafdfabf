// Cameras as kernels see them.
#pragma once

#include "render/renderer.h"
#include "shared/gpu_types.glsl.h"

#include <cstdint>

namespace tetrec {

// With `grid` x `grid` rays per pixel; `first_pixel` of its target among those of all views;
// `start_tet` as FindTet returns it.
gpu_types::GpuView MakeGpuView(const RenderView& view, int grid, uint32_t first_pixel,
                               uint32_t start_tet);

}  // namespace tetrec
