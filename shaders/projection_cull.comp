// Bounds of every tet's projection: the tiles that may contain its rays, if any.
//
// A tet that reaches behind the camera is clipped there: an edge that leaves the half space in
// front runs to infinity in the image, on the side where it passes the camera. The bounds contain
// the vertices in front and these directions.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "projection.glsl"
#include "thread_index.glsl"
#include "views.glsl"

layout(binding = kBindTets) uniform utextureBuffer tets;
layout(binding = kBindVertices) uniform textureBuffer vertices;
layout(std430, binding = kBindRectangles) writeonly buffer Rectangles { uvec2 rectangles[]; };
layout(std430, binding = kBindVisible) writeonly buffer Visible { uint visible[]; };

const float kInfinity = 3.0e38;
// Rounding of coordinates relative to the distance, here and in the ray's frame: a few ulp each.
const float kRounding = 2e-6;
// Points farther from the axis than 1 / this times their depth are outside every image.
const float kLeastSlope = 1e-5;

struct Bounds {
  vec2 low, high;  // [px]
};

void AddVertex(inout Bounds bounds, vec3 p, vec2 focal, vec2 center) {
  vec2 slope = p.xy / p.z;
  float distance = abs(p.x) + abs(p.y) + abs(p.z);
  vec2 rounding = kRounding * (distance / p.z * (1.0 + abs(slope)) * focal + abs(center));
  vec2 at = slope * focal + center;
  bounds.low = min(bounds.low, at - rounding);
  bounds.high = max(bounds.high, at + rounding);
}

// Adds the edge from a vertex in front to one behind.
void AddDirection(inout Bounds bounds, vec3 front, vec3 behind) {
  vec2 a = behind.xy * front.z, b = front.xy * behind.z;
  vec2 rounding = 2.0 * kRounding * (abs(a) + abs(b));
  if (a.x - b.x >= -rounding.x) bounds.high.x = kInfinity;
  if (a.x - b.x <= rounding.x) bounds.low.x = -kInfinity;
  if (a.y - b.y >= -rounding.y) bounds.high.y = kInfinity;
  if (a.y - b.y <= rounding.y) bounds.low.y = -kInfinity;
}

void main() {
  uint tet = ThreadIndex();
  bool exists = tet < push.count;
  uvec4 ids = texelFetch(tets, int(exists ? 2u * tet : 0u));
  GpuView view = FetchView(push.view);
  vec2 focal = vec2(view.right_in_world_fx.w, view.down_in_world_fy.w);
  vec2 center = vec2(view.forward_in_world_cx.w, view.center_in_world_cy.w);
  vec3 p[4];
  bool in_front[4];
  Bounds bounds = Bounds(vec2(kInfinity), vec2(-kInfinity));
  for (int i = 0; i < 4; ++i) {
    vec3 r = texelFetch(vertices, int(2u * ids[i])).xyz - view.center_in_world_cy.xyz;
    p[i] = vec3(dot(r, view.right_in_world_fx.xyz), dot(r, view.down_in_world_fy.xyz),
                dot(r, view.forward_in_world_cx.xyz));
    in_front[i] = p[i].z > kLeastSlope * (abs(p[i].x) + abs(p[i].y));
    if (in_front[i]) AddVertex(bounds, p[i], focal, center);
  }
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      if (in_front[i] && !in_front[j]) AddDirection(bounds, p[i], p[j]);
    }
  }
  // Pixels of the rectangle whose centre, moved by the jitter, can be within the bounds.
  vec2 reach = vec2(0.5 * abs(push.rays.jitter_px));
  vec2 size = vec2(kBlockWidth * push.block_columns, kBlockHeight * push.block_rows);
  vec2 first = vec2(push.first_x, push.first_y) + 0.5;
  vec2 low = ceil(clamp(bounds.low - reach - first, vec2(-2.0), size + 1.0));
  vec2 high = floor(clamp(bounds.high + reach - first, vec2(-2.0), size + 1.0));
  low = max(low, vec2(0.0));
  high = min(high, size - 1.0);
  bool seen = exists && low.x <= high.x && low.y <= high.y;
  uvec2 tile = uvec2(kBlockWidth * kTileColumns, kBlockHeight * kTileRows);
  if (seen) rectangles[tet] = PackRectangle(uvec2(low) / tile, uvec2(high) / tile);
  // There is one element more than tets: its prefix sum is the number of visible tets.
  if (tet <= push.count) visible[tet] = seen ? 1u : 0u;
}
