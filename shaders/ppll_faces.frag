// Stores the face for every ray that passes it: as a node behind all others, counting the length of
// every list, or in lists of known lengths. One module does both, so that both decide alike.
#version 460
#extension GL_GOOGLE_include_directive : require

#include "ppll.glsl"

layout(std430, binding = kBindLists) readonly buffer Lists { uvec2 lists[]; };
// The last element, after those of the rays, counts the nodes.
layout(std430, binding = kBindListFills) buffer ListFills { uint list_fills[]; };
layout(std430, binding = kBindFragments) writeonly buffer Fragments { uvec2 fragments[]; };
layout(std430, binding = kBindAppended) writeonly buffer Appended { uvec4 appended[]; };
layout(std430, binding = kBindCounters) buffer Counters { uint counters[]; };

#include "ppll_face_view.glsl"
TETREC_FACE_VIEW(in)

// A normal float as mantissa x 2^exponent.
uint Mantissa(float x) { return (floatBitsToUint(x) & 0x7FFFFFu) | 0x800000u; }
int Exponent(float x) { return int(floatBitsToUint(x) >> 23 & 0xFFu); }

// Sign of a b - c d, exactly (barring underflow). Rounded products are in the right order or equal;
// if they are equal, the products of the mantissas decide.
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

// True if the edge from vertex a to vertex b, the one of higher id, is on the ray's left.
bool TurnsLeft(vec3 a, vec3 b) {
  float turn = CompareProducts(a.x, b.y, a.y, b.x);
  // The lower vertex is moved infinitely more than the higher, x more than y.
  if (turn == 0.0) turn = b.y;
  if (turn == 0.0) turn = -b.x;
  if (turn == 0.0) turn = -a.y;
  if (turn == 0.0) turn = a.x;
  return turn > 0.0;
}

// Counts fragments that it cannot store.
void Store(uint ray, uvec2 fragment) {
  uint place = atomicAdd(list_fills[ray], 1u);
  if (push.appends != 0u) {
    uint node = atomicAdd(list_fills[push.rays.ray_count], 1u);
    if (node < push.most_appended) appended[node] = uvec4(fragment, ray, place);
  } else {
    uvec2 list = lists[ray];
    if (place < list.y) {
      fragments[list.x + place] = fragment;
    } else {
      atomicAdd(counters[kCounterLostRays], 1u);  // the passes decided differently
    }
  }
}

// A vertex sheared so that the ray of slope `slope` is the axis: the ray passes the same faces in
// this frame as in any other that has it as an axis.
vec3 AlongRay(vec3 corner, vec2 axis, vec2 slope) {
  precise vec2 across = (corner.xy + axis) - slope * corner.z;
  return vec3(across, corner.z);
}

void main() {
  vec2 slope = (gl_FragCoord.xy + pixel_origin_focal.xy) / pixel_origin_focal.zw;
  vec2 axis = reference.xy - slope * reference.z;
  vec3 a = AlongRay(corner0, axis, slope);
  vec3 b = AlongRay(corner1, axis, slope);
  vec3 c = AlongRay(corner2, axis, slope);
  precise vec3 p = vec3(b.x * c.y, a.x * c.y, a.x * b.y);
  precise vec3 q = vec3(b.y * c.x, a.y * c.x, a.y * b.x);
  bvec3 left = greaterThan(p, q);
  TETREC_RARELY(any(equal(p, q))) {
    left = bvec3(TurnsLeft(b, c), TurnsLeft(a, c), TurnsLeft(a, b));
  }
  vec3 w = WeightsOf(p - q);
  float depth = w.x * a.z + w.y * b.z + w.z * c.z;
  if (left.z == left.x && left.z != left.y && depth + reference.z > 0.0) {
    bool outward = (face & 1u) != 0u;
    uint entering = left.z == outward ? 0u : 1u;
    // Distances count as in MakeListRay.
    float stretch = sqrt(1.0 + dot(slope, slope));
    float begin = max(dot(reference.xyz, vec3(slope, 1.0)) / stretch - reference.w, 0.0);
    float z = depth * stretch + (reference.z * stretch - begin);
    Store(RayOfPixel(uvec2(gl_FragCoord.xy)), uvec2(floatBitsToUint(z), (face & ~1u) | entering));
  }
}
