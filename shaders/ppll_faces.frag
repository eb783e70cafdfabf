// Appends the face to the list of every ray that passes it. One module counts and stores, so that both
// passes decide alike.
#version 460
#extension GL_GOOGLE_include_directive : require

#include "ppll.glsl"

layout(std430, binding = kBindLists) readonly buffer Lists { uvec2 lists[]; };
layout(std430, binding = kBindListFills) buffer ListFills { uint list_fills[]; };
layout(std430, binding = kBindFragments) writeonly buffer Fragments { uvec2 fragments[]; };
layout(std430, binding = kBindCounters) buffer Counters { uint counters[]; };

layout(location = 0) flat in vec3 position0;  // by ascending vertex id
layout(location = 1) flat in vec3 position1;
layout(location = 2) flat in vec3 position2;
layout(location = 3) flat in uint face;

// A normal float as mantissa x 2^exponent.
uint Mantissa(float x) { return (floatBitsToUint(x) & 0x7FFFFFu) | 0x800000u; }
int Exponent(float x) { return int(floatBitsToUint(x) >> 23 & 0xFFu); }

// Sign of a b - c d, exactly (barring underflow). Rounded products are in the right order or equal;
// of equal ones the mantissas' products tell.
float CompareProducts(float a, float b, float c, float d) {
  precise float p = a * b;
  precise float q = c * d;
  float result = p > q ? 1.0 : p < q ? -1.0 : 0.0;
  TETREC_RARELY(p == q && p != 0.0) {
    uint p_high, p_low, q_high, q_low;
    umulExtended(Mantissa(a), Mantissa(b), p_high, p_low);
    umulExtended(Mantissa(c), Mantissa(d), q_high, q_low);
    int shift = Exponent(a) + Exponent(b) - Exponent(c) - Exponent(d);
    if (shift > 0) p_high = p_high << 1 | p_low >> 31, p_low <<= 1;
    if (shift < 0) q_high = q_high << 1 | q_low >> 31, q_low <<= 1;
    bool more = p_high > q_high || (p_high == q_high && p_low > q_low);
    bool same = p_high == q_high && p_low == q_low;
    result = same ? 0.0 : more == p > 0.0 ? 1.0 : -1.0;
  }
  return result;
}

// Whether the ray has the way from vertex a to vertex b, the one of higher id, on its left.
bool TurnsLeft(vec3 a, vec3 b) {
  float turn = CompareProducts(a.x, b.y, a.y, b.x);
  // The lower vertex is moved infinitely more than the higher, x more than y.
  if (turn == 0.0) turn = b.y;
  if (turn == 0.0) turn = -b.x;
  if (turn == 0.0) turn = -a.y;
  if (turn == 0.0) turn = a.x;
  return turn > 0.0;
}

void main() {
  uint index = RayOfPixel(uvec2(gl_FragCoord.xy));
  ListRay list_ray = MakeListRay(index);
  vec3 a = InRayFrame(list_ray.ray, position0);
  vec3 b = InRayFrame(list_ray.ray, position1);
  vec3 c = InRayFrame(list_ray.ray, position2);
  bool ab = TurnsLeft(a, b), bc = TurnsLeft(b, c), ac = TurnsLeft(a, c);
  vec3 w = HitWeights(a, b, c);
  float z = w.x * a.z + w.y * b.z + w.z * c.z;
  if (list_ray.ray.valid && ab == bc && ab != ac && z > list_ray.camera_z) {
    uint place = atomicAdd(list_fills[index], 1u);
    if (push.only_counts == 0u) {
      uvec2 list = lists[index];
      bool outward = (face & 1u) != 0u;
      uint entering = ab == outward ? 0u : 1u;
      if (place < list.y) {
        fragments[list.x + place] = uvec2(floatBitsToUint(z), (face & ~1u) | entering);
      } else {
        atomicAdd(counters[kCounterLostRays], 1u);  // the passes decided unlike
      }
    }
  }
}
