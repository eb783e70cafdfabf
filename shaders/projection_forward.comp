// Composites a stretch of sorted tets, front to back: colour before the background and optical depth
// of every ray.
#version 460
#extension GL_GOOGLE_include_directive : require
#define MakePayload(color) (color)
#include "projection_rays.glsl"

layout(std430, binding = kBindRayColors) buffer RayColors { vec4 ray_colors[]; };

void main() {
  TileRay tile_ray = FindTileRay(gl_GlobalInvocationID.x);
  Ray ray = MakeMovedRay(tile_ray.index);
  vec4 result = vec4(0.0);
  if (push.is_first == 0u) result = ray_colors[tile_ray.index];
  vec3 color = result.rgb;
  float depth = result.a;  // optical
  uint i = tile_ray.range.x;
  bool go = tile_ray.exists && ray.valid && i < tile_ray.range.y && depth < push.stop_depth;
  while (go) {
    uint tet = tet_of_item[i];
    TetCut cut = CutTet(ray, tet);
    TETREC_RARELY(cut.hit) {
      vec3 k0 = FetchVertexColor(cut.ids.x);
      vec3 k1 = FetchVertexColor(cut.ids.y);
      vec3 k2 = FetchVertexColor(cut.ids.z);
      vec3 k3 = FetchVertexColor(cut.ids.w);
      vec3 color0 = cut.w0.x * k0 + cut.w0.y * k1 + cut.w0.z * k2 + cut.w0.w * k3;
      vec3 color1 = cut.w1.x * k0 + cut.w1.y * k1 + cut.w1.z * k2 + cut.w1.w * k3;
      float size = cut.z1 - cut.z0;
      float density0 = dot(cut.w0, cut.density), density1 = dot(cut.w1, cut.density);
      UseCell(tet, density0, density1, color0, color1);
      float s0 = density0 * size, s1 = density1 * size;
      SegmentWeights segment = SegmentWeights(0.0, 0.0);
      bool thick = IsThickSegment(kIntegral, s0, s1);
      if (!thick) segment = IntegrateUnlessThick(kIntegral, kSplits, s0, s1);
      TETREC_RARELY(thick) segment = IntegrateThickSegment(s0, s1);
      color += exp(-depth) * (segment.w0 * color0 + segment.w1 * color1);
      depth += 0.5 * (s0 + s1);
    }
    i += 1u;
    go = i < tile_ray.range.y && depth < push.stop_depth;
  }
  if (tile_ray.exists) ray_colors[tile_ray.index] = vec4(color, depth);
}
