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

void AddToCoefficient(uint first, int k, vec3 d, vec3 by_color) {
  vec3 gradient = HarmonicAt(k, d) * by_color;
  uint at = first + 3u * uint(k - 1);
  other_gradients[at] += ToSum(gradient.r);
  other_gradients[at + 1u] += ToSum(gradient.g);
  other_gradients[at + 2u] += ToSum(gradient.b);
}

void main() {
  uint row = ThreadIndex();
  if (row < push.row_count) {
    uint slot = 0u;
    while (slot < push.slots) {
      uint at = 3u * (slot * push.row_count + row);
      Sum r = color_gradients[at], g = color_gradients[at + 1u], b = color_gradients[at + 2u];
      if (r != Sum(0) || g != Sum(0) || b != Sum(0)) {
        color_gradients[at] = Sum(0);
        color_gradients[at + 1u] = Sum(0);
        color_gradients[at + 2u] = Sum(0);
        uint color = row * uint(kRowComponents) + kColorComponent;
        vertex_gradients[color] += r;
        vertex_gradients[color + 1u] += g;
        vertex_gradients[color + 2u] += b;
        vec3 by_color = vec3(float(r), float(g), float(b));
        vec3 d = DirectionTo(slot, PlaceOfRow(row));
        uint first = row * push.other_stride;
        AddToCoefficient(first, 1, d, by_color);
        AddToCoefficient(first, 2, d, by_color);
        AddToCoefficient(first, 3, d, by_color);
        if (kHarmonics > 3) {
          AddToCoefficient(first, 4, d, by_color);
          AddToCoefficient(first, 5, d, by_color);
          AddToCoefficient(first, 6, d, by_color);
          AddToCoefficient(first, 7, d, by_color);
          AddToCoefficient(first, 8, d, by_color);
        }
        if (kHarmonics > 8) {
          AddToCoefficient(first, 9, d, by_color);
          AddToCoefficient(first, 10, d, by_color);
          AddToCoefficient(first, 11, d, by_color);
          AddToCoefficient(first, 12, d, by_color);
          AddToCoefficient(first, 13, d, by_color);
          AddToCoefficient(first, 14, d, by_color);
          AddToCoefficient(first, 15, d, by_color);
        }
        has_gradients[row] = 1u;
      }
      slot += 1u;
    }
  }
}
