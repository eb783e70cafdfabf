// Backward pass over sorted lists: walks every ray back to front and adds its gradients to the
// vertices (gradients.glsl).
//
// The forward pass kept each ray's optical depth; subtracting the segments' depths again, last
// segment first, recovers the transmittance before each of them, whatever its opacity (the
// inversion trick of Weiss and Westermann 2022 divides by 1 - alpha instead). `behind` is the part
// of the loss behind the segment.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "atomic_sum.glsl"

vec3 g_color;

#define Payload float
#define MakePayload(color) dot(g_color, color)
#include "ppll.glsl"

layout(std430, binding = kBindRayColors) readonly buffer RayColors { vec4 ray_colors[]; };
layout(std430, binding = kBindRayEntries) readonly buffer RayEntries { uvec2 ray_entries[]; };
layout(std430, binding = kBindRayGradients) readonly buffer RayGradients { vec4 ray_gradients[]; };
layout(std430, binding = kBindCounters) buffer Counters { uint counters[]; };

#include "held_vertices.glsl"
#include "ppll_hits.glsl"

// Adds everything that segments contribute at a hit.
void DepositAt(inout HeldVertices held, Hit hit, vec3 end) {
  Hold(held, hit.ids);
  Deposit(held, hit.w, end);
#ifdef TETREC_POSITIONS
  DepositMove(held, hit.w, MoveOf(hit.slopes, end));
#endif
}

void main() {
  uint i = gl_GlobalInvocationID.x;
  bool exists = i < push.tile_pixels;
  uint pixel = exists ? i : 0u;
  uvec2 at = uvec2(push.tile_x + pixel % push.tile_width, push.tile_y + pixel / push.tile_width);
  uint index = RayOfPixel(at);
  ListRay list_ray = MakeListRay(at);
  uvec2 list = lists[index];
  vec4 gradient = ray_gradients[index];
  uvec2 entry = ray_entries[index];
  g_color = gradient.rgb;
#ifdef TETREC_POSITIONS
  world_from_ray = mat3(list_ray.ray.u, list_ray.ray.v, list_ray.ray.direction);
#endif
  uint n = entry.x;
  bool go = exists && n > 0u && gradient != vec4(0.0);
  float depth = uintBitsToFloat(entry.y);  // before the segment that ends at hit1
  float behind = gradient.w * exp(-ray_colors[index].w);
  bool is_last = true;
  HeldVertices held = HoldNothing();
  vec3 at_hit1 = vec3(0.0);  // dL/d(z, density, payload) of the segment behind hit1
  Hit hit1;
  if (go) hit1 = HitAt(list_ray.ray, fragments[list.x + n - 1u]);
  while (go) {
    n -= 1u;
    Hit hit0;
    if (n > 0u) {
      hit0 = HitAt(list_ray.ray, fragments[list.x + n - 1u]);
    } else {
      hit0 = HitBeforeFirst(list_ray, hit1);
    }
    vec3 at_hit0 = vec3(0.0);
    if (hit0.behind != kNoTet && hit1.before != kNoTet) {
      uint tet = TetBetween(list_ray, hit0, hit1);
      UseCell(tet, hit0.density, hit1.density, hit0.payload, hit1.payload);
      SegmentCut cut = CutAtZero(hit0.density, hit1.density);
      float size = (cut.end - cut.begin) * (hit1.z - hit0.z);
      float density0 = DensityOf(hit0.density), density1 = DensityOf(hit1.density);
      float k0 = mix(hit0.payload, hit1.payload, cut.begin);
      float k1 = mix(hit0.payload, hit1.payload, cut.end);
      float s0 = density0 * size, s1 = density1 * size;
      if (!is_last) depth = max(0.0, depth - 0.5 * (s0 + s1));
      is_last = false;
      SegmentAdjoint adjoint = IntegrateSegmentByWithDerivatives(kIntegral, kSplits, s0, s1);
      float t = exp(-depth);
      EndGradients ends = OfWhole(
          cut, GradientsOfEnds(adjoint, t, behind, size, density0, density1, k0, k1));
      if (kCells) AddToCell(tet, ends);
      at_hit0 = ends.entry;
      at_hit1 += ends.exit;
      behind += t * (adjoint.w0 * k0 + adjoint.w1 * k1);
    }
    DepositAt(held, hit1, at_hit1);
    TETREC_RARELY(hit0.behind == kNoTet || hit1.before == kNoTet) { LetGo(held); }  // across a gap
    at_hit1 = at_hit0;
    hit1 = hit0;
    go = n > 0u;
  }
  // The camera, if the ray starts in a tet.
  TETREC_RARELY(at_hit1 != vec3(0.0)) { DepositAt(held, hit1, at_hit1); }
  LetGo(held);
}
