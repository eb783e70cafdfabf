// The colour of every row as each view of a batch sees it (shared/harmonics.glsl.h): rows
// [slot][row], which the renderers read in place of the field's own colours.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/gpu_types.glsl.h"
layout(push_constant) uniform Push { ViewColorPush push; };
#include "view_colors.glsl"

layout(binding = kBindHarmonics) uniform textureBuffer harmonics;  // rows of push.other_stride
layout(std430, binding = kBindViewColors) writeonly buffer ViewColors { vec4 view_colors[]; };

void main() {
  uint row = ThreadIndex();
  if (row < push.row_count) {
    vec3 place = PlaceOfRow(row);
    vec3 base = texelFetch(vertices, int(ColorRow(row, push.first_cell))).rgb;
    int at = int(row * (push.other_stride / 4u));
    // Four coefficients are three texels. Those beyond kHarmonics are not used.
    vec3 c[16];
#define Unpack(first)                                                       \
  {                                                                         \
    vec4 t0 = texelFetch(harmonics, at + first * 3 / 4);                    \
    vec4 t1 = texelFetch(harmonics, at + first * 3 / 4 + 1);                \
    vec4 t2 = texelFetch(harmonics, at + first * 3 / 4 + 2);                \
    c[first] = t0.xyz, c[first + 1] = vec3(t0.w, t1.xy);                    \
    c[first + 2] = vec3(t1.zw, t2.x), c[first + 3] = t2.yzw;                \
  }
    Unpack(0)
    if (kHarmonics > 3) Unpack(4)
    if (kHarmonics > 8) {
      Unpack(8)
      Unpack(12)
    }
    uint slot = 0u;
    while (slot < push.slots) {
      vec3 d = DirectionTo(slot, place);
      vec3 color = base + HarmonicAt(1, d) * c[0] + HarmonicAt(2, d) * c[1] + HarmonicAt(3, d) * c[2];
      if (kHarmonics > 3) {
        color += HarmonicAt(4, d) * c[3] + HarmonicAt(5, d) * c[4] + HarmonicAt(6, d) * c[5] +
                 HarmonicAt(7, d) * c[6] + HarmonicAt(8, d) * c[7];
      }
      if (kHarmonics > 8) {
        color += HarmonicAt(9, d) * c[8] + HarmonicAt(10, d) * c[9] + HarmonicAt(11, d) * c[10] +
                 HarmonicAt(12, d) * c[11] + HarmonicAt(13, d) * c[12] + HarmonicAt(14, d) * c[13] +
                 HarmonicAt(15, d) * c[14];
      }
      view_colors[slot * push.row_count + row] = vec4(color, 0.0);
      slot += 1u;
    }
  }
}
