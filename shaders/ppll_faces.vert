// Covers every face of the mesh by a rectangle of pixels that holds all its rays; the fragments decide.
//
// The rasteriser rounds vertices to fractions of a pixel, so its word on who is inside would not be
// that of the ray. Six vertices a face, two triangles.
#version 460
#extension GL_GOOGLE_include_directive : require

#include "ppll.glsl"

layout(std430, binding = kBindFaces) readonly buffer Faces { uint faces[]; };

layout(location = 0) flat out vec3 position0;  // by ascending vertex id
layout(location = 1) flat out vec3 position1;
layout(location = 2) flat out vec3 position2;
layout(location = 3) flat out uint face;  // | 1 where this order winds outwards

// Far beyond any picture, still exact in fixed point after the clamp to it.
const float kFar = 1e9;
// Rounding of vertices (1/256) and of projections (1e-3 in pictures of 4096) stay far below.
const float kMargin = 1.0 / 16.0;

struct Bounds {
  vec2 low, high;
};

// Takes in the direction across the view in which a point of the camera's plane lies.
Bounds TakeInfinity(Bounds bounds, vec2 direction, float rounding) {
  bounds.low = mix(bounds.low, vec2(-kFar), lessThan(direction, vec2(rounding)));
  bounds.high = mix(bounds.high, vec2(kFar), greaterThan(direction, vec2(-rounding)));
  return bounds;
}

Bounds TakeVertex(Bounds bounds, vec3 p, vec2 image) {
  if (p.z > 0.0) {
    bounds.low = min(bounds.low, image);
    bounds.high = max(bounds.high, image);
  }
  return bounds;
}

Bounds TakeEdge(Bounds bounds, vec3 p, vec3 q, float rounding) {
  if ((p.z > 0.0) != (q.z > 0.0)) {
    float share = p.z / (p.z - q.z);
    bounds = TakeInfinity(bounds, mix(p.xy, q.xy, share), rounding);
  }
  return bounds;
}

vec3 InCamera(GpuView view, vec3 position) {
  vec3 r = position - view.center_in_world_cy.xyz;
  return vec3(dot(r, view.right_in_world_fx.xyz), dot(r, view.down_in_world_fy.xyz),
              dot(r, view.forward_in_world_cx.xyz));
}

vec2 InBatch(GpuView view, vec3 p, vec2 first_pixel) {
  vec2 focal = vec2(view.right_in_world_fx.w, view.down_in_world_fy.w);
  vec2 center = vec2(view.forward_in_world_cx.w, view.center_in_world_cy.w);
  return clamp(focal * p.xy / p.z, -kFar, kFar) + center - Jitter(0u) - first_pixel;
}

float Size(vec3 p) { return max(abs(p.x), max(abs(p.y), abs(p.z))); }

// Pixels of the batch that may see the triangle.
Bounds BoundsOf(GpuView view, vec3 a, vec3 b, vec3 c, vec2 first_pixel) {
  Bounds bounds = Bounds(vec2(kFar), vec2(-kFar));
  bounds = TakeVertex(bounds, a, InBatch(view, a, first_pixel));
  bounds = TakeVertex(bounds, b, InBatch(view, b, first_pixel));
  bounds = TakeVertex(bounds, c, InBatch(view, c, first_pixel));
  // Coordinates are differences of numbers as large as the scene.
  float scene = Size(view.center_in_world_cy.xyz) + Size(push.mesh_ball.xyz) + push.mesh_ball.w;
  float rounding = 1e-6 * scene;
  bounds = TakeEdge(bounds, a, b, rounding);
  bounds = TakeEdge(bounds, b, c, rounding);
  bounds = TakeEdge(bounds, c, a, rounding);
  // A vertex that is all but the camera itself can be anywhere in the picture.
  bool at_camera = min(Size(a), min(Size(b), Size(c))) <= 1e-4 * scene;
  if (at_camera) bounds = Bounds(vec2(-kFar), vec2(kFar));
  return bounds;
}

void main() {
  uint vertex = uint(gl_VertexIndex);
  uint code = faces[vertex / 6u];
  uint i = code >> 1 & 3u;
  uvec3 ids = FaceVertices(texelFetch(tets, int(2u * (code >> 3))), i);
  bool outward = (i & 1u) == 0u;
  if (ids.x > ids.y) ids = ids.yxz, outward = !outward;
  if (ids.y > ids.z) ids = ids.xzy, outward = !outward;
  if (ids.x > ids.y) ids = ids.yxz, outward = !outward;
  position0 = texelFetch(vertices, int(2u * ids.x)).xyz;
  position1 = texelFetch(vertices, int(2u * ids.y)).xyz;
  position2 = texelFetch(vertices, int(2u * ids.z)).xyz;
  face = code | (outward ? 1u : 0u);

  GpuBlock first = blocks[0];
  GpuView view = views[first.view];
  Bounds bounds = BoundsOf(view, InCamera(view, position0), InCamera(view, position1),
                           InCamera(view, position2), vec2(first.x, first.y));
  vec2 size = vec2(push.block_columns * kBlockWidth,
                   push.ray_count / kBlockRays / push.block_columns * kBlockHeight);
  vec2 low = clamp(bounds.low - kMargin, vec2(-1.0), size + 1.0);
  vec2 high = clamp(bounds.high + kMargin, vec2(-1.0), size + 1.0);
  bool any = all(lessThan(low, high));
  uint corner = vertex % 6u;
  corner = corner < 3u ? corner : 6u - corner;  // 0 1 2, 3 2 1
  vec2 at = vec2((corner & 1u) != 0u ? high.x : low.x, (corner & 2u) != 0u ? high.y : low.y);
  gl_Position = any ? vec4(2.0 * at / size - 1.0, 0.5, 1.0) : vec4(2.0, 2.0, 0.5, 1.0);
}
