// Forward pass over sorted lists: colour before the background and optical depth of every ray.
#version 460
#extension GL_GOOGLE_include_directive : require

#define Payload vec3
#define MakePayload(color) (color)
#include "ppll.glsl"
#include "ppll_hits.glsl"

layout(std430, binding = kBindListFills) readonly buffer ListFills { uint list_fills[]; };
layout(std430, binding = kBindRayColors) writeonly buffer RayColors { vec4 ray_colors[]; };
layout(std430, binding = kBindRayEntries) writeonly buffer RayEntries { uvec2 ray_entries[]; };
layout(std430, binding = kBindCounters) buffer Counters { uint counters[]; };

// e^-88 is about the smallest float; what is behind cannot be seen and needs no gradient.
const float kUnseenDepth = 88.0;

#ifdef TETREC_COUNT_STEPS
// The tets that a ray passes form a chain from the one in which it starts, or none, to none: the
// sum (mod 2^32) of before - behind over the faces determines its start, in whatever order they
// come.
struct Chain {
  uint sum;  // of all faces
  // For the faces that are certainly in front of the camera, beyond rounding: the first one's
  // `before`, and the sum.
  bool has_far;
  uint far_begin, far_sum;
  uint steps;
};

// True if the faces of a whole ray form a chain that starts where the camera is. A camera that is
// on a face, up to rounding, may be on either side of it.
bool IsWhole(Chain chain, ListRay list_ray) {
  const float rounding = 1e-4;
  uint start = list_ray.ray.start_tet, begin = chain.has_far ? chain.far_begin : kNoTet;
  bool whole = chain.sum + kNoTet == start;
  TETREC_RARELY(!whole) {
    bool begins_well = begin == start;
    if (begin != kNoTet) {
      begins_well = begins_well || LeastWeight(list_ray, list_ray.camera_z, begin) >= -rounding;
    } else if (start != kNoTet) {
      begins_well = LeastWeight(list_ray, list_ray.camera_z, start) <= rounding;
    }
    whole = begins_well && chain.far_sum + kNoTet == begin;
  }
  return whole;
}
#endif

void main() {
  uint i = gl_GlobalInvocationID.x;
  bool exists = i < push.tile_pixels;
  uint pixel = exists ? i : 0u;
  uvec2 at = uvec2(push.tile_x + pixel % push.tile_width, push.tile_y + pixel / push.tile_width);
  uint index = RayOfPixel(at);
  ListRay list_ray = MakeListRay(at);
  uvec2 list = lists[index];
  bool go = exists && list.y > 0u;
  vec3 color = vec3(0.0);
  float depth = 0.0;  // optical
  uint n = 0u;
  uint last = 0u;  // fragments up to the end of the last visible segment
  float depth_before_last = 0.0;
#ifdef TETREC_COUNT_STEPS
  Chain chain = Chain(0u, false, kNoTet, 0u, 0u);
  float far = list_ray.camera_z + 1e-5 * push.mesh_ball.w;
#endif
  Hit hit0;
  if (go) hit0 = HitBeforeFirst(list_ray, HitAt(list_ray.ray, fragments[list.x]));
  while (go) {
    Hit hit1 = HitAt(list_ray.ray, fragments[list.x + n]);
    n += 1u;
    if (hit0.behind != kNoTet && hit1.before != kNoTet) {
      UseCell(TetBetween(list_ray, hit0, hit1), hit0.density, hit1.density, hit0.payload, hit1.payload);
      SegmentCut cut = CutAtZero(hit0.density, hit1.density);
      float size = (cut.end - cut.begin) * (hit1.z - hit0.z);
      float s0 = DensityOf(hit0.density) * size, s1 = DensityOf(hit1.density) * size;
      SegmentWeights segment = IntegrateSegmentBy(kIntegral, kSplits, s0, s1);
      color += exp(-depth) * (segment.w0 * mix(hit0.payload, hit1.payload, cut.begin) +
                            segment.w1 * mix(hit0.payload, hit1.payload, cut.end));
      if (depth < kUnseenDepth) {
        last = n;
        depth_before_last = depth;
      }
      depth += 0.5 * (s0 + s1);
#ifdef TETREC_COUNT_STEPS
      chain.steps += 1u;
#endif
    }
#ifdef TETREC_COUNT_STEPS
    uint link = hit1.before - hit1.behind;
    if (!chain.has_far && hit1.z > far) chain.far_begin = hit1.before;
    chain.has_far = chain.has_far || hit1.z > far;
    chain.sum += link;
    chain.far_sum += chain.has_far ? link : 0u;
#endif
    hit0 = hit1;
    go = n < list.y && depth < push.rays.stop_depth;
  }
  if (exists) {
    ray_colors[index] = vec4(color, depth);
    ray_entries[index] = uvec2(last, floatBitsToUint(depth_before_last));
    if (list_fills[index] != list.y) atomicAdd(counters[kCounterLostRays], 1u);
#ifdef TETREC_COUNT_STEPS
    atomicAdd(counters[kCounterSteps], chain.steps);
    if (chain.steps > 0u) atomicAdd(counters[kCounterHitRays], 1u);
    bool whole = depth >= push.rays.stop_depth || IsWhole(chain, list_ray);
    if (list_ray.ray.valid && !whole) atomicAdd(counters[kCounterLostRays], 1u);
#endif
  }
}
