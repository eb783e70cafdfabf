// Forward pass over sorted lists: colour before the background and optical depth of every ray.
#version 460
#extension GL_GOOGLE_include_directive : require

#define Payload vec3
#define MakePayload(color) (color)
#include "ppll_hits.glsl"

layout(std430, binding = kBindListFills) readonly buffer ListFills { uint list_fills[]; };
layout(std430, binding = kBindRayColors) writeonly buffer RayColors { vec4 ray_colors[]; };
layout(std430, binding = kBindRayEntries) writeonly buffer RayEntries { uvec2 ray_entries[]; };
layout(std430, binding = kBindCounters) buffer Counters { uint counters[]; };

// e^-88 is the least float; what lies behind is not seen and needs no gradient.
const float kUnseenDepth = 88.0;

void main() {
  uint i = gl_GlobalInvocationID.x;
  bool exists = i < push.tile_pixels;
  uint pixel = exists ? i : 0u;
  uint index = RayOfPixel(uvec2(push.tile_x + pixel % push.tile_width,
                                push.tile_y + pixel / push.tile_width));
  ListRay list_ray = MakeListRay(index);
  uvec2 list = lists[index];
  bool go = exists && list.y > 0u;
  vec3 color = vec3(0.0);
  float depth = 0.0;  // optical
  uint n = 0u;
  uint last = 0u;  // fragments up to the end of the last segment that is seen
  float depth_before_last = 0.0;
  Hit hit0;
  if (go) hit0 = HitBeforeFirst(list_ray, HitAt(list_ray.ray, fragments[list.x]));
  while (go) {
    Hit hit1 = HitAt(list_ray.ray, fragments[list.x + n]);
    n += 1u;
    if (hit0.behind != kNoTet && hit1.before != kNoTet) {
      float size = hit1.z - hit0.z;
      UseCell(hit0.behind, hit0.density, hit1.density, hit0.payload, hit1.payload);
      float s0 = hit0.density * size, s1 = hit1.density * size;
      SegmentWeights segment = IntegrateSegmentBy(kIntegral, kSplits, s0, s1);
      color += exp(-depth) * (segment.w0 * hit0.payload + segment.w1 * hit1.payload);
      if (depth < kUnseenDepth) {
        last = n;
        depth_before_last = depth;
      }
      depth += 0.5 * (s0 + s1);
    }
    hit0 = hit1;
    go = n < list.y && depth < push.stop_depth;
  }
  if (exists) {
    ray_colors[index] = vec4(color, depth);
    ray_entries[index] = uvec2(last, floatBitsToUint(depth_before_last));
    if (list_fills[index] != list.y) atomicAdd(counters[kCounterLostRays], 1u);
  }
}
