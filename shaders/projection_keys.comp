// Keys by which tets are sorted front to back.
//
// Centroid: the depth of the centroid along the camera's axis. Power: |e - c|^2 - r^2 of the eye e
// with respect to the circumsphere (c, r), minus |e|^2, which all share: q - 2 e.c with q = |c|^2 -
// r^2. Along a ray it grows from tet to tet of a Delaunay mesh (Edelsbrunner 1990, "An acyclicity
// theorem for cell complexes in d dimensions"). Neighbours that are almost on one sphere differ
// little, so it is evaluated in pairs of floats (Dekker 1971), which gives two words.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "projection.glsl"
#include "thread_index.glsl"
#include "exact.glsl"

layout(std430, binding = kBindItems) readonly buffer Items { uint items[]; };
layout(std430, binding = kBindKeys) writeonly buffer Keys { uint keys[]; };
#ifdef TETREC_POWER
layout(binding = kBindSpheres) uniform textureBuffer spheres;
layout(std430, binding = kBindHighKeys) writeonly buffer HighKeys { uint high_keys[]; };
#else
#include "views.glsl"
layout(binding = kBindTets) uniform utextureBuffer tets;
layout(binding = kBindVertices) uniform textureBuffer vertices;
#endif

// An integer that sorts like the float.
uint Sortable(float value) {
  uint bits = floatBitsToUint(value == 0.0 ? 0.0 : value);
  return (bits & 0x80000000u) != 0u ? ~bits : bits | 0x80000000u;
}

void main() {
  uint i = ThreadIndex();
  if (i < push.count) {
    uint tet = items[i];
#ifdef TETREC_POWER
    vec4 high = texelFetch(spheres, int(2u * tet)), low = texelFetch(spheres, int(2u * tet + 1u));
    vec2 power = vec2(high.w, low.w);
    power = AddPairs(power, MultiplyPairs(vec2(high.x, low.x), -2.0 * vec2(push.eye_high.x, push.eye_low.x)));
    power = AddPairs(power, MultiplyPairs(vec2(high.y, low.y), -2.0 * vec2(push.eye_high.y, push.eye_low.y)));
    power = AddPairs(power, MultiplyPairs(vec2(high.z, low.z), -2.0 * vec2(push.eye_high.z, push.eye_low.z)));
    high_keys[tet] = Sortable(power.x);
    keys[i] = Sortable(power.y);
#else
    uvec4 ids = texelFetch(tets, int(2u * tet));
    GpuView view = FetchView(push.view);
    vec3 sum = vec3(0.0);
    for (int k = 0; k < 4; ++k) {
      sum += texelFetch(vertices, int(2u * ids[k])).xyz - view.center_in_world_cy.xyz;
    }
    keys[i] = Sortable(dot(0.25 * sum, view.forward_in_world_cx.xyz));
#endif
  }
}
