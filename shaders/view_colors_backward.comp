// Adds the gradients of the colours that the views of a batch saw (view_colors.comp) to those of
// colours and coefficients, and clears them. With c(d) = c + sum_k c_k Y_k(d), dL/dc_k = Y_k dL/dc(d).
#version 460
#extension GL_GOOGLE_include_directive : require
#ifdef TETREC_FIXED_POINT
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#define Sum int64_t
#define ToSum(x) int64_t(roundEven(x))
#else
#define Sum float
#define ToSum(x) (x)
#endif
#define TETREC_NEVER (push.row_count == 0u)
#include "view_colors.glsl"

layout(std430, binding = kBindColorGradients) buffer ColorGradients { Sum color_gradients[]; };
layout(std430, binding = kBindVertexGradients) buffer VertexGradients { Sum vertex_gradients[]; };
layout(std430, binding = kBindOtherGradients) buffer OtherGradients { Sum other_gradients[]; };
layout(std430, binding = kBindHasGradients) writeonly buffer HasGradients { uint has_gradients[]; };
// The same sums as texels, which are read whole.
layout(binding = kBindColorGradientTexels) uniform textureBuffer color_gradient_texels;
layout(binding = kBindOtherGradientTexels) uniform textureBuffer other_gradient_texels;

// The sums of a row over all slots, and whether any is not 0.
bool has_any = false;
Sum by_red = Sum(0), by_green = Sum(0), by_blue = Sum(0);
vec3 by_coefficient[kMostHarmonics] =
    vec3[kMostHarmonics](vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0),
                         vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0));

#define AddHarmonic(k) by_coefficient[k - 1] += HarmonicAt(k, d) * by_color;

// Takes the gradients of one slot. Everything happens in registers: rows of coefficients are long,
// and to add to them for each slot would cost more than all rays. Most rows have no ray in most
// slots.
void TakeSlot(uint slot, uint row, vec3 place) {
  uint texel = slot * push.row_count + row, at = kColorGradientStride * texel;
#ifdef TETREC_FIXED_POINT
  Sum r = color_gradients[at], g = color_gradients[at + 1u], b = color_gradients[at + 2u];
#else
  vec4 sums = texelFetch(color_gradient_texels, int(texel));
  Sum r = sums.r, g = sums.g, b = sums.b;
#endif
  TETREC_RARELY(r != Sum(0) || g != Sum(0) || b != Sum(0)) {
    color_gradients[at] = Sum(0);
    color_gradients[at + 1u] = Sum(0);
    color_gradients[at + 2u] = Sum(0);
    by_red += r;
    by_green += g;
    by_blue += b;
    has_any = true;
    vec3 by_color = vec3(float(r), float(g), float(b));
    vec3 d = DirectionTo(slot, place);
    AddHarmonic(1) AddHarmonic(2) AddHarmonic(3)
    if (kHarmonics > 3) {
      AddHarmonic(4) AddHarmonic(5) AddHarmonic(6) AddHarmonic(7) AddHarmonic(8)
    }
    if (kHarmonics > 8) {
      AddHarmonic(9) AddHarmonic(10) AddHarmonic(11) AddHarmonic(12) AddHarmonic(13)
      AddHarmonic(14) AddHarmonic(15)
    }
  }
}

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
  uint color = row * uint(kRowComponents) + kColorComponent;
  vertex_gradients[color] += by_red;
  vertex_gradients[color + 1u] += by_green;
  vertex_gradients[color + 2u] += by_blue;
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
  uint row = ThreadIndex();
  if (row < push.row_count) {
    vec3 place = PlaceOfRow(row);
    uint slot = 0u;
    while (slot < push.slots) {
      TakeSlot(slot, row, place);
      slot += 1u;
    }
    TETREC_RARELY(has_any) GiveAll(row);
  }
}
