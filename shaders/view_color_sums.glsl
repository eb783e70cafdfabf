// What the two kernels share that turn gradients of what the views of a batch saw (view_colors.comp)
// into those of colours, densities and coefficients: the sums of a row over all views. With
// c(d) = c + sum_k c_k Y_k(d), dL/dc_k = Y_k dL/dc(d).
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

layout(std430, binding = kBindSlotGradients) buffer SlotGradients { Sum slot_gradients[]; };
layout(std430, binding = kBindVertexGradients) buffer VertexGradients { Sum vertex_gradients[]; };
// The sums of slots as texels, which are read whole.
layout(binding = kBindSlotGradientTexels) uniform textureBuffer slot_gradient_texels;

layout(std430, binding = kBindSeenRows) readonly buffer SeenRows { uint seen_rows[]; };

// The sums of a row over all slots.
Sum by_red = Sum(0), by_green = Sum(0), by_blue = Sum(0), by_density = Sum(0);
vec3 by_coefficient[kMostHarmonics] =
    vec3[kMostHarmonics](vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0),
                         vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0));

#define AddHarmonic(k) by_coefficient[k - 1] += HarmonicAt(k, d) * by_color;

// Takes the gradients of one slot, and clears them. Slots that do not exist count as 0.
void TakeSlot(uint slot, uint row, vec3 place) {
  bool exists = slot < push.slots;
  uint texel = (exists ? slot : 0u) * push.row_count + row, at = uint(kRowComponents) * texel;
#ifdef TETREC_FIXED_POINT
  Sum r = slot_gradients[at], g = slot_gradients[at + 1u], b = slot_gradients[at + 2u];
  Sum density = slot_gradients[at + 3u];
#else
  vec4 sums = texelFetch(slot_gradient_texels, int(texel));
  Sum r = sums.r, g = sums.g, b = sums.b, density = sums.a;
#endif
  r = exists ? r : Sum(0);
  g = exists ? g : Sum(0);
  b = exists ? b : Sum(0);
  by_red += r;
  by_green += g;
  by_blue += b;
  by_density += exists ? density : Sum(0);
  vec3 by_color = vec3(float(r), float(g), float(b));
  vec3 d = DirectionTo(exists ? slot : 0u, place);
  AddHarmonic(1) AddHarmonic(2) AddHarmonic(3)
  if (kHarmonics > 3) {
    AddHarmonic(4) AddHarmonic(5) AddHarmonic(6) AddHarmonic(7) AddHarmonic(8)
  }
  if (kHarmonics > 8) {
    AddHarmonic(9) AddHarmonic(10) AddHarmonic(11) AddHarmonic(12) AddHarmonic(13)
    AddHarmonic(14) AddHarmonic(15)
  }
}

void ClearSlot(uint slot, uint row) {
  uint at = uint(kRowComponents) * (slot * push.row_count + row);
  slot_gradients[at] = Sum(0);
  slot_gradients[at + 1u] = Sum(0);
  slot_gradients[at + 2u] = Sum(0);
  slot_gradients[at + 3u] = Sum(0);
}

// Takes the gradients of all slots. Everything happens in registers: rows of coefficients are long,
// and to add to them for each slot would cost more than all rays. Four slots at once, because on
// lavapipe a loop, and a branch too, copies all of these registers.
void TakeSlots(uint row) {
  vec3 place = PlaceOfRow(row);
  uint slot = 0u;
  while (slot < push.slots) {
    TakeSlot(slot, row, place);
    TakeSlot(slot + 1u, row, place);
    TakeSlot(slot + 2u, row, place);
    TakeSlot(slot + 3u, row, place);
    slot += 4u;
  }
  slot = 0u;
  while (slot < push.slots) {
    ClearSlot(slot, row);
    slot += 1u;
  }
}

// Adds the sums to the gradients of colour and density themselves.
void GiveRow(uint row) {
  uint color = row * uint(kRowComponents) + kColorComponent;
  vertex_gradients[color] += by_red;
  vertex_gradients[color + 1u] += by_green;
  vertex_gradients[color + 2u] += by_blue;
  vertex_gradients[row * uint(kRowComponents) + kDensityComponent] += by_density;
}
