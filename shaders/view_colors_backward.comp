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
#include "view_colors.glsl"

layout(std430, binding = kBindColorGradients) buffer ColorGradients { Sum color_gradients[]; };
layout(std430, binding = kBindVertexGradients) buffer VertexGradients { Sum vertex_gradients[]; };
layout(std430, binding = kBindOtherGradients) buffer OtherGradients { Sum other_gradients[]; };
layout(std430, binding = kBindHasGradients) writeonly buffer HasGradients { uint has_gradients[]; };

// The sums of a row over all slots, and whether any is not 0.
bool has_any = false;
Sum by_red = Sum(0), by_green = Sum(0), by_blue = Sum(0);
vec3 by_coefficient[kMostHarmonics];

#define AddHarmonic(k) by_coefficient[k - 1] += HarmonicAt(k, d) * by_color;

// Takes the gradients of one slot. Everything happens in registers: rows of coefficients are long,
// and to add to them for each slot would cost more than all rays.
void TakeSlot(uint slot, uint row, vec3 place) {
  uint at = 3u * (slot * push.row_count + row);
  Sum r = color_gradients[at], g = color_gradients[at + 1u], b = color_gradients[at + 2u];
  if (r != Sum(0) || g != Sum(0) || b != Sum(0)) {
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

void Give(uint first, int k) {
  uint at = first + 3u * uint(k - 1);
  other_gradients[at] += ToSum(by_coefficient[k - 1].r);
  other_gradients[at + 1u] += ToSum(by_coefficient[k - 1].g);
  other_gradients[at + 2u] += ToSum(by_coefficient[k - 1].b);
}

void GiveAll(uint row) {
  has_gradients[row] = 1u;
  uint color = row * uint(kRowComponents) + kColorComponent;
  vertex_gradients[color] += by_red;
  vertex_gradients[color + 1u] += by_green;
  vertex_gradients[color + 2u] += by_blue;
  uint first = row * push.other_stride;
  Give(first, 1);
  Give(first, 2);
  Give(first, 3);
  if (kHarmonics > 3) {
    Give(first, 4);
    Give(first, 5);
    Give(first, 6);
    Give(first, 7);
    Give(first, 8);
  }
  if (kHarmonics > 8) {
    Give(first, 9);
    Give(first, 10);
    Give(first, 11);
    Give(first, 12);
    Give(first, 13);
    Give(first, 14);
    Give(first, 15);
  }
}

void main() {
  uint row = ThreadIndex();
  if (row < push.row_count) {
    int k = 0;
    while (k < kMostHarmonics) {
      by_coefficient[k] = vec3(0.0);
      k += 1;
    }
    vec3 place = PlaceOfRow(row);
    uint slot = 0u;
    while (slot < push.slots) {
      TakeSlot(slot, row, place);
      slot += 1u;
    }
    if (has_any) GiveAll(row);
  }
}
