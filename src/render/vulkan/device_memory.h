// The memory that a field takes on a device, and what the device has.
#pragma once

#include "core/free_memory.h"
#include "field/radiance_field.h"
#include "gpu/device.h"

namespace tetrec {

// Bytes that UploadField and AllocatePositionGradients will take on the device.
uint64_t FieldBytes(const TetMesh& mesh, const FieldLayout& layout, bool fixed_point,
                    size_t views_per_batch);

// For a software device, the memory that the host can spare without swapping; for others, their
// largest heap.
FreeMemory MeasureFreeMemory(const Device& device);

}  // namespace tetrec
