// Computes density and colour of the field that the renderers read from its parameters, by the same
// arithmetic as adam.comp: a field that is read back and set again is the same to the bit.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/adam.glsl.h"
#include "shared/gpu_types.glsl.h"
#include "thread_index.glsl"

layout(local_size_x = kWorkgroupSize) in;
layout(std430, binding = kBindParameters) readonly buffer Parameters { float parameters[]; };
layout(std430, binding = kBindVertices) buffer Vertices { vec4 vertices[]; };
layout(push_constant) uniform Push { SpreadPush push; };

#include "storage.glsl"
#include "density.glsl"

void main() {
  uint row = ThreadIndex();
  if (row < push.row_count) {
    uint first = row * uint(kRowComponents), color = first + kColorComponent;
    vertices[DensityRow(row, push.first_cell)].w =
        DensityOfParameter(parameters[first + kDensityComponent], push.density_scale);
    vertices[ColorRow(row, push.first_cell)].rgb =
        vec3(parameters[color], parameters[color + 1u], parameters[color + 2u]);
  }
}
