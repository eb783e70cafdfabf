// Covers every face of the mesh with a triangle of pixels that contains all its rays; the fragments
// decide.
//
// The rasteriser rounds vertices to fractions of a pixel, so its decision on what is inside would
// not be that of the ray: it gets the face with a margin around it. Faces that are thinner than the
// margin or that reach far outside the image or behind the camera are covered by a rectangle,
// inside a triangle.
#version 460
#extension GL_GOOGLE_include_directive : require

#include "ppll.glsl"

layout(std430, binding = kBindFaces) readonly buffer Faces { uint faces[]; };
layout(std430, binding = kBindFaceChunks) readonly buffer FaceChunks { uint face_chunks[]; };

#include "ppll_face_view.glsl"
TETREC_FACE_VIEW(out)

// Far outside any image, and still exact in fixed point after the clamp.
const float kFar = 1e9;
// [px] Far above the rounding of vertices (1/256) and of projections (1e-3 in images of 4096 px).
const float kMargin = 1.0 / 16.0;
// [px] Farther out, projections are not precise enough.
const float kNear = 16384.0;

struct Bounds {
  vec2 low, high;
};

// Extends the bounds to infinity in the direction of a point in the camera's plane.
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

// Along the camera's axes. Equal positions give equal bits.
vec3 InCamera(GpuView view, vec3 position, vec3 origin) {
  precise vec3 r = position - origin;
  precise vec3 p = vec3(dot(r, view.right_in_world_fx.xyz), dot(r, view.down_in_world_fy.xyz),
                        dot(r, view.forward_in_world_cx.xyz));
  return p;
}

vec2 InBatch(GpuView view, vec3 p, vec2 first_pixel) {
  vec2 focal = vec2(view.right_in_world_fx.w, view.down_in_world_fy.w);
  vec2 center = vec2(view.forward_in_world_cx.w, view.center_in_world_cy.w);
  return clamp(focal * p.xy / p.z, -kFar, kFar) + center - Jitter(0u) - first_pixel;
}

float Size(vec3 p) { return max(abs(p.x), max(abs(p.y), abs(p.z))); }

// Coordinates are differences of numbers as large as this.
float SceneSize(GpuView view) {
  return Size(view.center_in_world_cy.xyz) + Size(push.mesh_ball.xyz) + push.mesh_ball.w;
}

// Pixels of the batch that may see the triangle.
Bounds BoundsOf(vec3 corners[3], vec2 images[3], float scene) {
  Bounds bounds = Bounds(vec2(kFar), vec2(-kFar));
  bounds = TakeVertex(bounds, corners[0], images[0]);
  bounds = TakeVertex(bounds, corners[1], images[1]);
  bounds = TakeVertex(bounds, corners[2], images[2]);
  float rounding = 1e-6 * scene;
  bounds = TakeEdge(bounds, corners[0], corners[1], rounding);
  bounds = TakeEdge(bounds, corners[1], corners[2], rounding);
  bounds = TakeEdge(bounds, corners[2], corners[0], rounding);
  // A vertex that almost coincides with the camera can be anywhere in the image.
  bool at_camera = min(Size(corners[0]), min(Size(corners[1]), Size(corners[2]))) <= 1e-4 * scene;
  if (at_camera) bounds = Bounds(vec2(-kFar), vec2(kFar));
  return bounds;
}

// Corner 0, 1 or 2 of the smallest triangle around a rectangle that has two sides along it.
vec2 CornerAround(vec2 low, vec2 high, uint corner) {
  return vec2(corner == 1u ? 2.0 * high.x - low.x : low.x, corner == 2u ? 2.0 * high.y - low.y : low.y);
}

// A vertex of the triangle moved outwards so that all three sides are kMargin farther out.
struct Widened {
  bool holds;  // false: the triangle is too thin
  vec2 at;
};

Widened Widen(vec2 images[3], uint corner) {
  // As seen from the incentre, everything is scaled by 1 + margin / inradius.
  vec3 sides = vec3(distance(images[1], images[2]), distance(images[2], images[0]),
                    distance(images[0], images[1]));
  vec2 u = images[1] - images[0], v = images[2] - images[0];
  float around = sides.x + sides.y + sides.z;
  float radius = abs(u.x * v.y - u.y * v.x) / around;
  vec2 center = (sides.x * images[0] + sides.y * images[1] + sides.z * images[2]) / around;
  vec2 from_center = images[corner] - center;
  return Widened(radius > kMargin, images[corner] + kMargin / radius * from_center);
}

void main() {
  uint vertex = uint(gl_VertexIndex);
  uint corner = vertex % 3u;
  uint place = vertex / 3u;
  uint index = face_chunks[push.first_chunk + place / kFacesPerChunk] * kFacesPerChunk +
               place % kFacesPerChunk;
  bool exists = index < push.face_count;
  uint code = faces[exists ? index : 0u];
  uint i = code >> 1 & 3u;
  uvec3 ids = FaceVertices(texelFetch(tets, int(2u * (code >> 3))), i);
  bool outward = (i & 1u) == 0u;
  if (ids.x > ids.y) ids = ids.yxz, outward = !outward;
  if (ids.y > ids.z) ids = ids.xzy, outward = !outward;
  if (ids.x > ids.y) ids = ids.yxz, outward = !outward;
  vec3 position0 = texelFetch(vertices, int(2u * ids.x)).xyz;
  vec3 position1 = texelFetch(vertices, int(2u * ids.y)).xyz;
  vec3 position2 = texelFetch(vertices, int(2u * ids.z)).xyz;
  face = code | (outward ? 1u : 0u);

  GpuBlock first = FetchBlock(0u);
  GpuView view = FetchView(push.view);
  vec3 eye = view.center_in_world_cy.xyz;
  bool is_inside = view.size_pixel_tet.w != kNoTet;
  vec3 origin = is_inside ? eye : push.mesh_ball.xyz;
  corner0 = InCamera(view, position0, origin);
  corner1 = InCamera(view, position1, origin);
  corner2 = InCamera(view, position2, origin);
  reference = vec4(InCamera(view, origin, eye), is_inside ? 0.0 : push.mesh_ball.w);
  vec2 center = vec2(view.forward_in_world_cx.w, view.center_in_world_cy.w);
  pixel_origin_focal = vec4(vec2(first.x, first.y) + Jitter(0u) - center,
                            view.right_in_world_fx.w, view.down_in_world_fy.w);
  vec3 corners[3] = vec3[](InCamera(view, position0, eye), InCamera(view, position1, eye),
                           InCamera(view, position2, eye));
  vec2 first_pixel = vec2(first.x, first.y);
  vec2 images[3] = vec2[](InBatch(view, corners[0], first_pixel), InBatch(view, corners[1], first_pixel),
                          InBatch(view, corners[2], first_pixel));
  float scene = SceneSize(view);
  Bounds bounds = BoundsOf(corners, images, scene);
  vec2 size = vec2(push.block_columns * kBlockWidth,
                   push.rays.ray_count / kBlockRays / push.block_columns * kBlockHeight);
  vec2 low = clamp(bounds.low - kMargin, vec2(-1.0), size + 1.0);
  vec2 high = clamp(bounds.high + kMargin, vec2(-1.0), size + 1.0);
  // A pixel's ray passes through its centre.
  bool any = exists && all(lessThanEqual(ceil(low - 0.5), floor(high - 0.5)));
  vec2 at = CornerAround(low, high, corner);
  // The ray's origin is rounded to 1e-7 of the scene.
  float nearest = min(corners[0].z, min(corners[1].z, corners[2].z));
  float focal = max(view.right_in_world_fx.w, view.down_in_world_fy.w);
  bool is_near = all(greaterThan(bounds.low, vec2(-kNear))) && all(lessThan(bounds.high, vec2(kNear)));
  if (is_near && nearest > 4e-6 * focal * scene) {
    Widened widened = Widen(images, corner);
    if (widened.holds) at = widened.at;
  }
  gl_Position = any ? vec4(2.0 * at / size - 1.0, 0.5, 1.0) : vec4(2.0, 2.0, 0.5, 1.0);
}
