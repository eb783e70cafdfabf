// Adds the gradients of what the views of a batch saw to those of colours and densities, and moves the
// coefficients (shared/adam.glsl.h) at once: storing and reading their sums would cost as much again. The result is that of view_colors_backward.comp followed by adam_others.comp, bit by bit
// with fixed-point sums.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/gpu_types.glsl.h"
layout(push_constant) uniform Push { ViewColorStepPush push; };
#include "shared/adam.glsl.h"
#include "view_color_sums.glsl"

layout(std430, binding = kBindParameters) writeonly buffer Parameters { float parameters[]; };
layout(std430, binding = kBindMoments) buffer Moments { float moments[]; };
layout(std430, binding = kBindRowRates) readonly buffer RowRates { vec4 row_rates[]; };
layout(binding = kBindHarmonics) uniform textureBuffer harmonics;  // `parameters` as texels

// The sums are in quanta; storing them would have rounded them.
void InUnitsOfValue() {
#ifdef TETREC_FIXED_POINT
  int k = 0;
  while (k < kHarmonics) {
    by_coefficient[k] = push.quantum * roundEven(by_coefficient[k]);
    k += 1;
  }
#endif
}

// In the order of components, as in adam_others.comp, so that both give the same bits.
float Squares() {
  precise float squares = 0.0;
#define AddSquares(k)                                             \
  squares += by_coefficient[k].r * by_coefficient[k].r;           \
  squares += by_coefficient[k].g * by_coefficient[k].g;           \
  squares += by_coefficient[k].b * by_coefficient[k].b;
  AddSquares(0) AddSquares(1) AddSquares(2)
  if (kHarmonics > 3) {
    AddSquares(3) AddSquares(4) AddSquares(5) AddSquares(6) AddSquares(7)
  }
  if (kHarmonics > 8) {
    AddSquares(8) AddSquares(9) AddSquares(10) AddSquares(11) AddSquares(12) AddSquares(13) AddSquares(14)
  }
  return squares;
}

void MoveTexel(uint texel, float decay, float rate, vec4 gradient) {
  vec4 before = texelFetch(harmonics, int(texel));
  precise vec4 next = vec4(SharedStep(before.x, decay, rate, gradient.x),
                           SharedStep(before.y, decay, rate, gradient.y),
                           SharedStep(before.z, decay, rate, gradient.z),
                           SharedStep(before.w, decay, rate, gradient.w));
  uint at = 4u * texel;
  parameters[at] = next.x;
  parameters[at + 1u] = next.y;
  parameters[at + 2u] = next.z;
  parameters[at + 3u] = next.w;
}

// Four coefficients are three texels.
#define MoveFour(texel, c0, c1, c2, c3)                     \
  {                                                         \
    MoveTexel(texel, decay, rate, vec4(c0, c1.r));          \
    MoveTexel(texel + 1u, decay, rate, vec4(c1.gb, c2.rg)); \
    MoveTexel(texel + 2u, decay, rate, vec4(c2.b, c3));     \
  }

// Without a branch, which would copy all registers; a row whose gradients are all 0 stays.
void MoveRow(uint row, float squares) {
  uint moment = row * push.moment_stride;
  float before = moments[moment];
  bool moves = squares > 0.0;
  float second = moves ? SharedMoment(before, squares / float(3 * kHarmonics), push.beta2) : before;
  moments[moment] = second;
  float rate = moves ? SharedRate(row_rates[row].x * push.rate, second, push.epsilon) : 0.0;
  float decay = moves ? row_rates[row].x * push.decay : 0.0;
  uint texel = row * (push.other_stride / 4u);
  MoveFour(texel, by_coefficient[0], by_coefficient[1], by_coefficient[2], by_coefficient[3])
  if (kHarmonics > 3) {
    MoveFour(texel + 3u, by_coefficient[4], by_coefficient[5], by_coefficient[6], by_coefficient[7])
  }
  if (kHarmonics > 8) {
    MoveFour(texel + 6u, by_coefficient[8], by_coefficient[9], by_coefficient[10], by_coefficient[11])
    MoveFour(texel + 9u, by_coefficient[12], by_coefficient[13], by_coefficient[14], vec3(0.0))
  }
}

void main() {
  uint index = ThreadIndex();
  TETREC_RARELY(index < seen_rows[kSeenRowsCount]) {
    uint row = seen_rows[kSeenRowsHeader + index];
    TakeSlots(row);
    GiveRow(row);
    InUnitsOfValue();
    MoveRow(row, Squares());
  }
}
