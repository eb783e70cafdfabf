// Adds the gradients of what the views of a batch saw to those of colours, densities and coefficients.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/gpu_types.glsl.h"
layout(push_constant) uniform Push { ViewColorPush push; };
#include "view_color_sums.glsl"

layout(std430, binding = kBindOtherGradients) buffer OtherGradients { Sum other_gradients[]; };
layout(std430, binding = kBindHasGradients) writeonly buffer HasGradients { uint has_gradients[]; };
layout(binding = kBindOtherGradientTexels) uniform textureBuffer other_gradient_texels;  // the same sums

// Adds four sums to a texel of gradients of coefficients.
void Give(uint texel, vec4 sums) {
  uint at = 4u * texel;
#ifdef TETREC_FIXED_POINT
  other_gradients[at] += ToSum(sums.x);
  other_gradients[at + 1u] += ToSum(sums.y);
  other_gradients[at + 2u] += ToSum(sums.z);
  other_gradients[at + 3u] += ToSum(sums.w);
#else
  sums += texelFetch(other_gradient_texels, int(texel));
  other_gradients[at] = sums.x;
  other_gradients[at + 1u] = sums.y;
  other_gradients[at + 2u] = sums.z;
  other_gradients[at + 3u] = sums.w;
#endif
}

// Four coefficients are three texels.
#define GiveFour(texel, c0, c1, c2, c3)           \
  {                                               \
    Give(texel, vec4(c0, c1.r));                  \
    Give(texel + 1u, vec4(c1.gb, c2.rg));         \
    Give(texel + 2u, vec4(c2.b, c3));             \
  }

void GiveAll(uint row) {
  has_gradients[row] = 1u;
  GiveRow(row);
  uint texel = row * (push.other_stride / 4u);
  GiveFour(texel, by_coefficient[0], by_coefficient[1], by_coefficient[2], by_coefficient[3])
  if (kHarmonics > 3) {
    GiveFour(texel + 3u, by_coefficient[4], by_coefficient[5], by_coefficient[6], by_coefficient[7])
  }
  if (kHarmonics > 8) {
    GiveFour(texel + 6u, by_coefficient[8], by_coefficient[9], by_coefficient[10], by_coefficient[11])
    GiveFour(texel + 9u, by_coefficient[12], by_coefficient[13], by_coefficient[14], vec3(0.0))
  }
}

void main() {
  uint index = ThreadIndex();
  TETREC_RARELY(index < seen_rows[kSeenRowsCount]) {
    uint row = seen_rows[kSeenRowsHeader + index];
    TakeSlots(row);
    GiveAll(row);
  }
}
