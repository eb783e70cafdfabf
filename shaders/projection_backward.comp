// Backward pass over a stretch of sorted tets, front to back: adds every ray's gradients to the
// vertices (gradients.glsl). The part of the loss behind a segment is the ray's part minus those of
// the segments up to and including it.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "atomic_sum.glsl"

vec3 g_color;

#define MakePayload(color) dot(g_color, color)
#include "projection_rays.glsl"

layout(std430, binding = kBindRayColors) readonly buffer RayColors { vec4 ray_colors[]; };
layout(std430, binding = kBindRayGradients) readonly buffer RayGradients { vec4 ray_gradients[]; };
layout(std430, binding = kBindCounters) buffer Counters { uint counters[]; };

#include "held_vertices.glsl"

// The state of a ray on its way, kept from stretch to stretch.
struct Walk {
  HeldVertices held;
  float depth;   // optical, before the segment
  float behind;  // the part of the loss behind
};
layout(std430, binding = kBindRayStates) buffer RayStates { Walk ray_states[]; };

vec4 PayloadOf(uvec4 ids) {
  return vec4(MakePayload(FetchVertexColor(ids.x)),
              MakePayload(FetchVertexColor(ids.y)),
              MakePayload(FetchVertexColor(ids.z)),
              MakePayload(FetchVertexColor(ids.w)));
}

#ifdef TETREC_POSITIONS
struct TetCorner {
  uint id;
  vec3 p;
  float density, payload;
};

void SortTwo(inout TetCorner a, inout TetCorner b) {
  TetCorner first = a;
  bool swaps = b.id < a.id;
  if (swaps) a = b;
  if (swaps) b = first;
}

// Slopes at the end on the face that lacks one vertex. The contributions of both tets of a face to
// its corners cancel almost entirely, so both must compute the same slopes to the last bit: from
// its corners in the order of their ids.
Slopes SlopesOnTetFace(TetCut cut, bvec4 lacks, vec4 payload) {
  TetCorner c0 = TetCorner(cut.ids.x, cut.a, cut.density.x, payload.x);
  TetCorner c1 = TetCorner(cut.ids.y, cut.b, cut.density.y, payload.y);
  TetCorner c2 = TetCorner(cut.ids.z, cut.c, cut.density.z, payload.z);
  TetCorner c3 = TetCorner(cut.ids.w, cut.d, cut.density.w, payload.w);
  if (lacks.x) c0 = c3;
  if (lacks.y) c1 = c3;
  if (lacks.z) c2 = c3;
  SortTwo(c0, c1);
  SortTwo(c1, c2);
  SortTwo(c0, c1);
  return SlopesOnFace(
      FaceCorners(c0.p, c1.p, c2.p, vec3(c0.density, c1.density, c2.density),
                  vec3(c0.payload, c1.payload, c2.payload)),
      vec3(EdgeFunction(c1.p, c2.p), EdgeFunction(c2.p, c0.p), EdgeFunction(c0.p, c1.p)));
}
#endif

// Adds the gradients of a segment to the vertices of its tet.
void Pass(inout Walk walk, TetCut cut, uint tet) {
  vec4 payload = PayloadOf(cut.ids);
  float value0 = dot(cut.w0, payload), value1 = dot(cut.w1, payload);
  float density0 = dot(cut.w0, cut.density), density1 = dot(cut.w1, cut.density);
  UseCell(tet, density0, density1, value0, value1);
  SegmentCut part = CutAtZero(density0, density1);
  float size = (part.end - part.begin) * (cut.z1 - cut.z0);
  density0 = DensityOf(density0);
  density1 = DensityOf(density1);
  float k0 = mix(value0, value1, part.begin), k1 = mix(value0, value1, part.end);
  float s0 = density0 * size, s1 = density1 * size;
  SegmentAdjoint adjoint = SegmentAdjoint(0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
  bool thick = IsThickSegment(kIntegral, s0, s1);
  if (!thick) adjoint = IntegrateUnlessThickWithDerivatives(kIntegral, kSplits, s0, s1);
  TETREC_RARELY(thick) adjoint = IntegrateThickSegmentWithDerivatives(s0, s1);
  float t = exp(-walk.depth);
  walk.behind -= t * (adjoint.w0 * k0 + adjoint.w1 * k1);
  EndGradients ends =
      OfWhole(part, GradientsOfEnds(adjoint, t, walk.behind, size, density0, density1, k0, k1));
  if (kCells) AddToCell(tet, ends);
  Hold(walk.held, cut.ids);
  Deposit(walk.held, cut.w0, ends.entry);
  Deposit(walk.held, cut.w1, ends.exit);
#ifdef TETREC_POSITIONS
  Slopes slopes0 = SlopesOnTetFace(cut, cut.face0, payload);
  TETREC_RARELY(cut.at_camera) {
    slopes0 = SlopesInTet(cut.a, cut.b, cut.c, cut.d, cut.density, payload);
  }
  DepositMove(walk.held, cut.w0, MoveOf(slopes0, ends.entry));
  DepositMove(walk.held, cut.w1, MoveOf(SlopesOnTetFace(cut, cut.face1, payload), ends.exit));
  // A passage ends where the mesh does.
  bvec4 is_open = equal(texelFetch(tets, int(2u * tet + 1u)), uvec4(kNoTet));
  TETREC_RARELY(any(bvec4(uvec4(is_open) & uvec4(cut.face1)))) { LetGo(walk.held); }
#endif
  walk.depth += 0.5 * (s0 + s1);
}

void main() {
  TileRay tile_ray = FindTileRay(gl_GlobalInvocationID.x);
  Ray ray = MakeMovedRay(tile_ray.index);
  vec4 gradient = ray_gradients[tile_ray.index];
  vec4 result = ray_colors[tile_ray.index];
  g_color = gradient.rgb;
#ifdef TETREC_POSITIONS
  world_from_ray = mat3(ray.u, ray.v, ray.direction);
#endif
  Walk walk;
  walk.held = HoldNothing();
  walk.depth = 0.0;
  walk.behind = dot(g_color, result.rgb) + gradient.w * exp(-result.w);
  if (push.is_first == 0u && tile_ray.exists) walk = ray_states[tile_ray.index];
  uint i = tile_ray.range.x;
  bool go = tile_ray.exists && ray.valid && gradient != vec4(0.0) && i < tile_ray.range.y &&
            walk.depth < push.rays.stop_depth;
  while (go) {
    uint tet = tet_of_item[i];
    TetCut cut = CutTet(ray, tet);
    TETREC_RARELY(cut.hit) { Pass(walk, cut, tet); }
    i += 1u;
    go = i < tile_ray.range.y && walk.depth < push.rays.stop_depth;
  }
  if (push.is_last != 0u) {
    LetGo(walk.held);
  } else if (tile_ray.exists) {
    ray_states[tile_ray.index] = walk;
  }
}
