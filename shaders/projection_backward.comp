// Backward pass over a stretch of sorted tets, front to back (see march_backward.comp for the way the
// part of the loss behind a segment is kept).
#version 460
#extension GL_GOOGLE_include_directive : require
#include "atomic_sum.glsl"
#define MakePayload(color) dot(gradient.rgb, color)
#include "projection_rays.glsl"

layout(std430, binding = kBindRayColors) readonly buffer RayColors { vec4 ray_colors[]; };
layout(std430, binding = kBindRayGradients) readonly buffer RayGradients { vec4 ray_gradients[]; };
layout(std430, binding = kBindRayStates) buffer RayStates { vec2 ray_states[]; };
layout(std430, binding = kBindVertexGradients) buffer VertexGradients { Sum vertex_gradients[]; };

// x: the sum of colour weights, y: dL/ddensity.
void Deposit(uint id, vec3 g_color, vec2 gradient) {
  if (gradient.x != 0.0 || gradient.y != 0.0) {
    AddTo(vertex_gradients[4u * id], g_color.r * gradient.x, 1.0);
    AddTo(vertex_gradients[4u * id + 1u], g_color.g * gradient.x, 1.0);
    AddTo(vertex_gradients[4u * id + 2u], g_color.b * gradient.x, 1.0);
    AddTo(vertex_gradients[4u * id + 3u], gradient.y, 1.0);
  }
}

void main() {
  TileRay tile_ray = FindTileRay(gl_GlobalInvocationID.x);
  Ray ray = MakeMovedRay(tile_ray.index);
  vec4 gradient = ray_gradients[tile_ray.index];
  vec4 result = ray_colors[tile_ray.index];
  vec2 state = vec2(0.0, dot(gradient.rgb, result.rgb) + gradient.w * exp(-result.w));
  if (push.is_first == 0u) state = ray_states[tile_ray.index];
  float depth = state.x;  // optical, before the segment
  float behind = state.y;
  uint i = tile_ray.range.x;
  bool go = tile_ray.exists && ray.valid && i < tile_ray.range.y && depth < push.stop_depth;
  while (go) {
    uint tet = tet_of_item[i];
    TetCut cut = CutTet(ray, tet);
    TETREC_RARELY(cut.hit) {
      vec4 payload = vec4(MakePayload(FetchVertexColor(cut.ids.x)),
                          MakePayload(FetchVertexColor(cut.ids.y)),
                          MakePayload(FetchVertexColor(cut.ids.z)),
                          MakePayload(FetchVertexColor(cut.ids.w)));
      float k0 = dot(cut.w0, payload), k1 = dot(cut.w1, payload);
      float size = cut.z1 - cut.z0;
      float density0 = dot(cut.w0, cut.density), density1 = dot(cut.w1, cut.density);
      UseCell(tet, density0, density1, k0, k1);
      float s0 = density0 * size, s1 = density1 * size;
      SegmentAdjoint adjoint = SegmentAdjoint(0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
      bool thick = IsThickSegment(kIntegral, s0, s1);
      if (!thick) adjoint = IntegrateUnlessThickWithDerivatives(kIntegral, kSplits, s0, s1);
      TETREC_RARELY(thick) adjoint = IntegrateThickSegmentWithDerivatives(s0, s1);
      float t = exp(-depth);
      behind -= t * (adjoint.w0 * k0 + adjoint.w1 * k1);
      float by_s0 = t * (adjoint.dw0_ds0 * k0 + adjoint.dw1_ds0 * k1);
      float by_s1 = t * (adjoint.dw0_ds1 * k0 + adjoint.dw1_ds1 * k1);
      vec2 at_entry = vec2(t * adjoint.w0, size * (by_s0 - 0.5 * behind));
      vec2 at_exit = vec2(t * adjoint.w1, size * (by_s1 - 0.5 * behind));
      if (kCells) {
        Deposit(tet, gradient.rgb, at_entry + at_exit);
      } else {
        Deposit(cut.ids.x, gradient.rgb, cut.w0.x * at_entry + cut.w1.x * at_exit);
        Deposit(cut.ids.y, gradient.rgb, cut.w0.y * at_entry + cut.w1.y * at_exit);
        Deposit(cut.ids.z, gradient.rgb, cut.w0.z * at_entry + cut.w1.z * at_exit);
        Deposit(cut.ids.w, gradient.rgb, cut.w0.w * at_entry + cut.w1.w * at_exit);
      }
      depth += 0.5 * (s0 + s1);
    }
    i += 1u;
    go = i < tile_ray.range.y && depth < push.stop_depth;
  }
  if (tile_ray.exists) ray_states[tile_ray.index] = vec2(depth, behind);
}
