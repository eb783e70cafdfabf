// Backward pass: walks every ray again, front to back, and adds its gradients to the vertices
// (gradients.glsl). The part of the loss behind segment i is the ray's part minus those of the
// segments up to and including i.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "atomic_sum.glsl"

vec3 g_color;

#define Payload float
#define MakePayload(color) dot(g_color, color)
#include "march.glsl"
#include "gradients.glsl"

layout(std430, binding = kBindRayColors) readonly buffer RayColors { vec4 ray_colors[]; };
layout(std430, binding = kBindRayEntries) readonly buffer RayEntries { Entry ray_entries[]; };
layout(std430, binding = kBindRayGradients) readonly buffer RayGradients { vec4 ray_gradients[]; };

#ifdef TETREC_POSITIONS
Slopes SlopesOnTriangle(MarchState state) {
  FaceCorners face;
  face.a = state.a.p, face.b = state.b.p, face.c = state.c.p;
  face.density = vec3(state.a.density, state.b.density, state.c.density);
  face.payload = vec3(state.a.payload, state.b.payload, state.c.payload);
  return SlopesOnFace(face, state.e);
}

Slopes SlopesAtCamera(MarchState state, Corner apex) {
  return SlopesInTet(state.a.p, state.b.p, state.c.p, apex.p,
                     vec4(state.a.density, state.b.density, state.c.density, apex.density),
                     vec4(state.a.payload, state.b.payload, state.c.payload, apex.payload));
}
#endif

// The state of a ray on its way.
struct Walk {
  float depth;                  // optical, before the segment
  float behind_all;             // the part of the loss behind
  vec2 grad_a, grad_b, grad_c;  // of vertices of the triangle, until they leave it
#ifdef TETREC_POSITIONS
  vec3 move_a, move_b, move_c;
  vec3 end;  // dL/d(z, density, payload) at the last segment's end, which is the next one's start
#endif
};

// A segment between the entry and the exit triangle of a tet.
struct Segment {
  float density0, density1;  // values at its ends
  float k0, k1;              // g . colour at its ends
  SegmentCut cut;            // the part of it that has density
  float s0, s1, size;        // optical depths at the ends of this part, and its length
  uint leaving;        // corner of the entry triangle that the exit triangle lacks: 0 a, 1 b, 2 c
  uint leaving_id;
  uint tet;
  vec3 w_entry, w_exit;  // barycentric weights on the corners before and after the step
  float w_apex;          // of the entry point on the new corner; 0 except at a camera
#ifdef TETREC_POSITIONS
  Slopes slopes;  // at the start
#endif
};

// Adds the gradients of a segment to the corners and releases the one that leaves.
void Deposit(inout Walk walk, Segment segment, SegmentAdjoint adjoint) {
  float t = exp(-walk.depth);
  float k0 = mix(segment.k0, segment.k1, segment.cut.begin);
  float k1 = mix(segment.k0, segment.k1, segment.cut.end);
  walk.behind_all -= t * (adjoint.w0 * k0 + adjoint.w1 * k1);
  EndGradients ends =
      OfWhole(segment.cut, GradientsOfEnds(adjoint, t, walk.behind_all, segment.size,
                                           DensityOf(segment.density0), DensityOf(segment.density1),
                                           k0, k1));
  vec2 at_entry = ends.entry.yz, at_exit = ends.exit.yz;
  bool a_leaves = segment.leaving == 0u, b_leaves = segment.leaving == 1u;
  if (kCells) {
    AddToCell(segment.tet, ends);
  } else {
    walk.grad_a += segment.w_entry.x * at_entry;
    walk.grad_b += segment.w_entry.y * at_entry;
    walk.grad_c += segment.w_entry.z * at_entry;
    vec2 apex = segment.w_apex * at_entry;
    AddToVertex(segment.leaving_id, a_leaves ? walk.grad_a : b_leaves ? walk.grad_b : walk.grad_c);
    walk.grad_a = (a_leaves ? apex : walk.grad_a) + segment.w_exit.x * at_exit;
    walk.grad_b = (b_leaves ? apex : walk.grad_b) + segment.w_exit.y * at_exit;
    walk.grad_c = (a_leaves || b_leaves ? walk.grad_c : apex) + segment.w_exit.z * at_exit;
  }
#ifdef TETREC_POSITIONS
  vec3 move = MoveOf(segment.slopes, walk.end + ends.entry);
  walk.end = ends.exit;
  walk.move_a += segment.w_entry.x * move;
  walk.move_b += segment.w_entry.y * move;
  walk.move_c += segment.w_entry.z * move;
  move *= segment.w_apex;
  AddMoveToVertex(segment.leaving_id,
                  a_leaves ? walk.move_a : b_leaves ? walk.move_b : walk.move_c);
  walk.move_a = a_leaves ? move : walk.move_a;
  walk.move_b = b_leaves ? move : walk.move_b;
  walk.move_c = a_leaves || b_leaves ? walk.move_c : move;
#endif
  walk.depth += 0.5 * (segment.s0 + segment.s1);
}

// Releases the corners of the triangle through which the ray leaves the mesh.
void FlushTriangle(inout Walk walk, MarchState state, Segment segment) {
  if (!kCells) {
    AddToVertex(state.a.id, walk.grad_a);
    AddToVertex(state.b.id, walk.grad_b);
    AddToVertex(state.c.id, walk.grad_c);
    walk.grad_a = walk.grad_b = walk.grad_c = vec2(0.0);
  }
#ifdef TETREC_POSITIONS
  vec3 move = MoveOf(SlopesOnTriangle(state), walk.end);
  AddMoveToVertex(state.a.id, walk.move_a + segment.w_exit.x * move);
  AddMoveToVertex(state.b.id, walk.move_b + segment.w_exit.y * move);
  AddMoveToVertex(state.c.id, walk.move_c + segment.w_exit.z * move);
  walk.move_a = walk.move_b = walk.move_c = walk.end = vec3(0.0);
#endif
}

void main() {
  uint index = gl_GlobalInvocationID.x;
  bool exists = index < push.rays.ray_count;
  uint read = exists ? index : 0u;
  Ray ray = MakeRay(read);
  g_first_color = ray.slot * push.row_count;
  vec4 gradient = ray_gradients[read];
  vec4 result = ray_colors[read];
  Entry entry = ray_entries[read];
  g_color = gradient.rgb;
  bool go = exists && ray.valid && (ray.start_tet != kNoTet || entry.x != kMiss) &&
            gradient != vec4(0.0);
  MarchState state;
  Begin begin;
  state.tet = kNoTet;
  BeginMarch(ray, entry, go, state, begin);
  bool hit = go;
  Entries entries;
  if (kAnyBoundary != 0) entries = EntriesFrom(ray, entry, state);

  Walk walk;
  walk.depth = 0.0;
  walk.behind_all = dot(g_color, result.rgb) + gradient.w * exp(-result.w);
  walk.grad_a = walk.grad_b = walk.grad_c = vec2(0.0);
#ifdef TETREC_POSITIONS
  world_from_ray = mat3(ray.u, ray.v, ray.direction);
  walk.move_a = walk.move_b = walk.move_c = walk.end = vec3(0.0);
#endif
  uint steps = 0u;
  Segment segment;
  segment.w_exit = begin.w;
  segment.w_apex = begin.w_apex;
  segment.k1 = begin.payload;
  segment.density1 = begin.density;
  float z0 = begin.z;
  while (go) {
    // Thick segments are integrated outside the inner loop, which they would slow down for all rays.
    bool thick = false;
    while (go && !thick) {
      segment.tet = state.tet;
      uvec4 ids = texelFetch(tets, int(2u * segment.tet));
      uvec4 neighbors = texelFetch(tets, int(2u * segment.tet + 1u));
      uvec3 corners = uvec3(state.a.id, state.b.id, state.c.id);
      segment.w_entry = segment.w_exit;
      segment.k0 = segment.k1;
      segment.density0 = segment.density1;
#ifdef TETREC_POSITIONS
      segment.slopes = SlopesOnTriangle(state);
      TETREC_RARELY(steps == 0u && ray.start_tet != kNoTet) {
        segment.slopes = SlopesAtCamera(state, FetchApex(ray, state, ids));
      }
#endif
      segment.leaving = StepThrough(state, FetchApex(ray, state, ids), ids, neighbors);
      segment.leaving_id = segment.leaving == 0u   ? corners.x
                           : segment.leaving == 1u ? corners.y
                                                   : corners.z;
      segment.w_exit = HitWeights(state);
      float z1 = max(z0, AtHit(segment.w_exit, state, p.z));
      segment.density1 = AtHit(segment.w_exit, state, density);
      segment.k1 = AtHit(segment.w_exit, state, payload);
      UseCell(segment.tet, segment.density0, segment.density1, segment.k0, segment.k1);
      segment.cut = CutAtZero(segment.density0, segment.density1);
      segment.size = (segment.cut.end - segment.cut.begin) * (z1 - z0);
      segment.s0 = DensityOf(segment.density0) * segment.size;
      segment.s1 = DensityOf(segment.density1) * segment.size;
      thick = IsThickSegment(kIntegral, segment.s0, segment.s1);
      if (!thick) {
        Deposit(walk, segment,
                IntegrateUnlessThickWithDerivatives(kIntegral, kSplits, segment.s0, segment.s1));
        segment.w_apex = 0.0;
      }
      z0 = z1;
      steps += 1u;
      go = state.tet != kNoTet && walk.depth < push.rays.stop_depth && steps < push.max_steps;
    }
    if (thick) {
      Deposit(walk, segment, IntegrateThickSegmentWithDerivatives(segment.s0, segment.s1));
      segment.w_apex = 0.0;
      go = go && walk.depth < push.rays.stop_depth;
    }
    if (kAnyBoundary != 0) {
      TETREC_RARELY(hit && MayEnter(entries) && state.tet == kNoTet && walk.depth < push.rays.stop_depth &&
                    steps < push.max_steps) {
        FlushTriangle(walk, state, segment);
        go = EnterAgain(ray, entries, state, begin);
        if (go) {
          segment.w_exit = begin.w;
          segment.k1 = begin.payload;
          z0 = max(z0, begin.z);
          segment.density1 = begin.density;
        }
      }
    }
  }
  if (hit) FlushTriangle(walk, state, segment);
}
