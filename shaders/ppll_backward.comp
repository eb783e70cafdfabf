// Backward pass over sorted lists: walks every ray back to front and adds its gradients to the
// vertices.
//
// The forward pass kept each ray's optical depth; taking the segments' depths off again, the last one
// first, gives back the transmittance before each of them, whatever its opacity (the inversion trick of
// Weiss and Westermann 2022 divides by 1 - alpha instead). `behind` is the part of the loss that lies
// behind, sum_j T_j (w0 g.c0 + w1 g.c1)_j + h T_end with g = dL/dcolour, h = dL/dtransmittance: a
// density change before it scales it by d(-tau), -1/2 for s0 and s1 each.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "atomic_sum.glsl"

vec3 g_color;

#define Payload float
#define MakePayload(color) dot(g_color, color)
#include "ppll_hits.glsl"

layout(std430, binding = kBindRayColors) readonly buffer RayColors { vec4 ray_colors[]; };
layout(std430, binding = kBindRayEntries) readonly buffer RayEntries { uvec2 ray_entries[]; };
layout(std430, binding = kBindRayGradients) readonly buffer RayGradients { vec4 ray_gradients[]; };
layout(std430, binding = kBindVertexGradients) buffer VertexGradients { Sum vertex_gradients[]; };

// x: sum of colour weights (dL/dcolour is g times it), y: dL/ddensity.
void Add(uint id, vec2 gradient) {
  if (gradient.x != 0.0 || gradient.y != 0.0) {
    AddTo(vertex_gradients[4u * id], g_color.r * gradient.x, 1.0);
    AddTo(vertex_gradients[4u * id + 1u], g_color.g * gradient.x, 1.0);
    AddTo(vertex_gradients[4u * id + 2u], g_color.b * gradient.x, 1.0);
    AddTo(vertex_gradients[4u * id + 3u], gradient.y, 1.0);
  }
}

void Deposit(Hit hit, vec2 gradient) {
  if (!kCells) {
    Add(hit.ids.x, hit.w.x * gradient);
    Add(hit.ids.y, hit.w.y * gradient);
    Add(hit.ids.z, hit.w.z * gradient);
    TETREC_RARELY(hit.w.w > 0.0) { Add(hit.ids.w, hit.w.w * gradient); }
  }
}

void main() {
  uint i = gl_GlobalInvocationID.x;
  bool exists = i < push.tile_pixels;
  uint pixel = exists ? i : 0u;
  uint index = RayOfPixel(uvec2(push.tile_x + pixel % push.tile_width,
                                push.tile_y + pixel / push.tile_width));
  ListRay list_ray = MakeListRay(index);
  uvec2 list = lists[index];
  vec4 gradient = ray_gradients[index];
  uvec2 entry = ray_entries[index];
  g_color = gradient.rgb;
  uint n = entry.x;
  bool go = exists && n > 0u && gradient != vec4(0.0);
  float depth = uintBitsToFloat(entry.y);  // before the segment that ends at hit1
  float behind = gradient.w * exp(-ray_colors[index].w);
  bool is_last = true;
  vec2 at_hit1 = vec2(0.0);  // of the segment behind hit1
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
    vec2 at_hit0 = vec2(0.0);
    if (hit0.behind != kNoTet && hit1.before != kNoTet) {
      float size = hit1.z - hit0.z;
      UseCell(hit0.behind, hit0.density, hit1.density, hit0.payload, hit1.payload);
      float s0 = hit0.density * size, s1 = hit1.density * size;
      if (!is_last) depth = max(0.0, depth - 0.5 * (s0 + s1));
      is_last = false;
      SegmentAdjoint adjoint = IntegrateSegmentByWithDerivatives(kIntegral, kSplits, s0, s1);
      float t = exp(-depth);
      float k0 = hit0.payload, k1 = hit1.payload;
      float by_s0 = t * (adjoint.dw0_ds0 * k0 + adjoint.dw1_ds0 * k1) - 0.5 * behind;
      float by_s1 = t * (adjoint.dw0_ds1 * k0 + adjoint.dw1_ds1 * k1) - 0.5 * behind;
      at_hit0 = vec2(t * adjoint.w0, size * by_s0);
      vec2 at_exit = vec2(t * adjoint.w1, size * by_s1);
      at_hit1 += at_exit;
      behind += t * (adjoint.w0 * k0 + adjoint.w1 * k1);
      if (kCells) Add(hit0.behind, at_hit0 + at_exit);
    }
    Deposit(hit1, at_hit1);
    at_hit1 = at_hit0;
    hit1 = hit0;
    go = n > 0u;
  }
  // The camera, where the ray begins in a tet.
  TETREC_RARELY(at_hit1 != vec2(0.0)) { Deposit(hit1, at_hit1); }
}
