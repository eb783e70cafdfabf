// Marching a ray from tet to tet through neighbour links.
//
// Everything happens in the ray's own frame: axes u, v across the ray, d along it, origin where the
// ray enters the mesh. A vertex is projected to (x, y) across and z along the ray. The state is the
// entry triangle (a, b, c), wound so that its three edge functions e are >= 0; e divided by its sum
// gives the barycentric weights of the hit point. Each step fetches the one vertex of the tet that
// is not on the entry triangle, replaces one corner with it and so obtains the exit triangle. No
// edge function is ever evaluated twice, so neighbouring tets cannot contradict each other.
//
// Every loop has one exit, tested at its top: lavapipe 22.3 computes wrong values after a loop that
// some lanes of a group leave by `break`.
//
// The including kernel defines Payload, the per-vertex quantity carried along with the density, and
// MakePayload(color).

#define TETREC_NEVER (push.rays.ray_count == 0u)

#include "shared/gpu_types.glsl.h"

layout(push_constant) uniform Push { MarchPush push; };

#include "rays.glsl"
#include "integral.glsl"

layout(local_size_x = kWorkgroupSize) in;

layout(binding = kBindTets) uniform utextureBuffer tets;
layout(binding = kBindVertices) uniform textureBuffer vertices;
layout(binding = kBindHull) uniform textureBuffer hull;
layout(std430, binding = kBindCounters) buffer Counters { uint counters[]; };

#include "cells.glsl"

const uint kMiss = 0xFFFFFFFFu;

// Not 0: the boundary may have any shape, and its faces are in a tree of boxes. 0: it is convex and
// has few faces.
layout(constant_id = kConstantAnyBoundary) const int kAnyBoundary = 0;

struct Corner {
  vec3 p;
  float density;
  Payload payload;
  uint id;
};

struct MarchState {
  Corner a, b, c;
  vec3 e;
  uint tet;
};

// Where a ray starts: on the entry triangle, or at a camera inside the first tet. w and w_apex are
// the barycentric weights of this point on the corners a, b, c and on the first tet's fourth
// vertex.
struct Begin {
  float z, density;
  Payload payload;
  vec3 w;
  float w_apex;
};

// A ray exactly through a vertex is made to pass beside it, always on the same side, so that it
// cannot circle there.
vec3 BesideTheRay(vec3 p) {
  if (p.x == 0.0 && p.y == 0.0) p.x = 1e-20;
  return p;
}

vec3 PlaceInRayFrame(Ray ray, uint id) {
  return BesideTheRay(InRayFrame(ray, texelFetch(vertices, int(2u * id)).xyz));
}

Corner FetchCorner(Ray ray, uint id) {
  vec4 place = texelFetch(vertices, int(2u * id));
  vec3 color = FetchVertexColor(id);
  Corner corner;
  corner.p = BesideTheRay(InRayFrame(ray, place.xyz));
  corner.density = place.w;
  corner.payload = MakePayload(color);
  corner.id = id;
  return corner;
}

#include "march_boundary.glsl"

float EdgeFunction(Corner from, Corner to) { return EdgeFunction(from.p, to.p); }

vec3 EdgeFunctions(Corner a, Corner b, Corner c) {
  return vec3(EdgeFunction(b, c), EdgeFunction(c, a), EdgeFunction(a, b));
}

float Least(vec3 e) { return min(e.x, min(e.y, e.z)); }

// Two rows for each plane of a convex boundary: the plane, then its first face and the one after
// its last.
int PlaneRow(uint plane) { return int(2u * (push.hull_faces + plane)); }

// The part of a line inside a convex boundary; empty if begin > end.
struct Chord {
  float begin, end;   // along the ray
  uint entry_plane;
  float exit_cosine;  // between the ray and the outward normal where it leaves
};

Chord FindChord(Ray ray) {
  Chord chord = Chord(-3.0e38, 3.0e38, 0u, 1.0);
  uint i = 0u;
  while (i < push.hull_planes) {
    vec4 plane = texelFetch(hull, PlaneRow(i));
    float along = dot(plane.xyz, ray.direction);
    float t = (plane.w - dot(plane.xyz, ray.origin)) / along;
    bool enters = along < 0.0 && t > chord.begin;
    bool leaves = along > 0.0 && t < chord.end;
    chord.begin = enters ? t : chord.begin;
    chord.entry_plane = enters ? i : chord.entry_plane;
    chord.end = leaves ? t : chord.end;
    chord.exit_cosine = leaves ? along : chord.exit_cosine;
    i += 1u;
  }
  return chord;
}

// A face through which a ray may enter, and how far inside it the ray is: the least edge function.
struct EntryFace {
  uint face;
  float inside;
};

// The face that contains the ray best, among those of a plane and `best`.
EntryFace BestFaceOfPlane(Ray ray, uint plane, EntryFace best) {
  uvec2 faces = floatBitsToUint(texelFetch(hull, PlaneRow(plane) + 1).xy);
  uint i = faces.x;
  while (i < faces.y) {
    uvec4 ids = floatBitsToUint(texelFetch(hull, int(2u * i + 1u)));
    vec3 a = PlaceInRayFrame(ray, ids.x), b = PlaceInRayFrame(ray, ids.y);
    vec3 c = PlaceInRayFrame(ray, ids.z);
    float inside = Least(vec3(EdgeFunction(b, c), EdgeFunction(c, a), EdgeFunction(a, b)));
    if (inside > best.inside) best = EntryFace(i, inside);
    i += 1u;
  }
  return best;
}

// The boundary's face at the origin of a ray that was moved to where it enters, or kMiss. If none
// of the entry plane's faces contains the ray (it meets an edge of the boundary), the faces of all
// planes that contain the origin within `rounding` are tried.
uint FindEntryFace(Ray ray, uint entry_plane, float rounding) {
  EntryFace best = BestFaceOfPlane(ray, entry_plane, EntryFace(kMiss, -3.0e38));
  TETREC_RARELY(best.inside < 0.0) {
    uint i = 0u;
    while (i < push.hull_planes) {
      vec4 plane = texelFetch(hull, PlaneRow(i));
      TETREC_RARELY(dot(plane.xyz, ray.direction) < 0.0 &&
                    abs(dot(plane.xyz, ray.origin) - plane.w) <= rounding) {
        best = BestFaceOfPlane(ray, i, best);
      }
      i += 1u;
    }
  }
  return best.inside >= 0.0 ? best.face : kMiss;
}

MarchState EnterThroughFace(Ray ray, uint face) {
  uvec4 ids = floatBitsToUint(texelFetch(hull, int(2u * face + 1u)));
  MarchState state;
  state.a = FetchCorner(ray, ids.x);
  state.b = FetchCorner(ray, ids.y);
  state.c = FetchCorner(ray, ids.z);
  state.e = EdgeFunctions(state.a, state.b, state.c);
  state.tet = ids.w;
  return state;
}

// A camera inside tet t: the entry triangle is the face through which the line entered behind the
// camera, the one of the four that contains the line best.
MarchState EnterFromInside(Ray ray, uint t) {
  uvec4 ids = texelFetch(tets, int(2u * t));
  Corner c0 = FetchCorner(ray, ids.x), c1 = FetchCorner(ray, ids.y);
  Corner c2 = FetchCorner(ray, ids.z), c3 = FetchCorner(ray, ids.w);
  // Faces wound inwards, so that an entry face is positive in the ray's frame.
  vec3 e0 = EdgeFunctions(c1, c3, c2), e1 = EdgeFunctions(c0, c2, c3);
  vec3 e2 = EdgeFunctions(c0, c3, c1), e3 = EdgeFunctions(c0, c1, c2);
  float l0 = Least(e0), l1 = Least(e1), l2 = Least(e2), l3 = Least(e3);
  MarchState state;
  state.tet = t;
  if (l0 >= l1 && l0 >= l2 && l0 >= l3) {
    state.a = c1, state.b = c3, state.c = c2, state.e = e0;
  } else if (l1 >= l2 && l1 >= l3) {
    state.a = c0, state.b = c2, state.c = c3, state.e = e1;
  } else if (l2 >= l3) {
    state.a = c0, state.b = c3, state.c = c1, state.e = e2;
  } else {
    state.a = c0, state.b = c1, state.c = c2, state.e = e3;
  }
  return state;
}

Corner FetchApex(Ray ray, MarchState state, uvec4 ids) {
  return FetchCorner(ray, ids.x ^ ids.y ^ ids.z ^ ids.w ^ state.a.id ^ state.b.id ^ state.c.id);
}

// Barycentric weights of the hit point on the triangle of the state.
vec3 HitWeights(MarchState state) {
  vec3 w = max(state.e, vec3(0.0));
  float sum = w.x + w.y + w.z;
  return sum > 0.0 ? w * (1.0 / sum) : vec3(1.0 / 3.0);  // one division, not three
}

#define AtHit(w, state, member) \
  ((w).x * (state).a.member + (w).y * (state).b.member + (w).z * (state).c.member)

// Puts `fresh` in place of the corner that the exit triangle does not share, and moves on to the
// neighbour there. Returns which corner left: 0 a, 1 b, 2 c.
uint StepThrough(inout MarchState state, Corner fresh, uvec4 ids, uvec4 neighbors) {
  float sa = EdgeFunction(state.a, fresh), sb = EdgeFunction(state.b, fresh);
  float sc = EdgeFunction(state.c, fresh);
  // How deep inside the three exit triangles the ray is: exactly one is positive, unless the ray
  // meets an edge or a vertex and rounding interferes; then the least wrong one is taken.
  float without_a = min(sc, -sb), without_b = min(sa, -sc), without_c = min(sb, -sa);
  bool c_leaves = without_c >= max(without_a, without_b);
  bool b_leaves = !c_leaves && without_b >= without_a;
  if (kAnyBoundary != 0) {
    // Signs alone decide, as for entries, so that walks and entries agree if the ray meets an edge.
    bool left_a = LeftOf(state.a.p, fresh.p), left_b = LeftOf(state.b.p, fresh.p);
    bool left_c = LeftOf(state.c.p, fresh.p);
    c_leaves = left_b && !left_a;
    b_leaves = left_a && !left_c;
  }
  uint leaving_id;
  uint leaving;
  if (c_leaves) {
    leaving = 2u;
    leaving_id = state.c.id;
    state.e = vec3(sb, -sa, state.e.z);
    state.c = fresh;
  } else if (b_leaves) {
    leaving = 1u;
    leaving_id = state.b.id;
    state.e = vec3(-sc, state.e.y, sa);
    state.b = fresh;
  } else {
    leaving = 0u;
    leaving_id = state.a.id;
    state.e = vec3(state.e.x, sc, -sb);
    state.a = fresh;
  }
  state.tet = ids.x == leaving_id   ? neighbors.x
              : ids.y == leaving_id ? neighbors.y
              : ids.z == leaving_id ? neighbors.z
                                    : neighbors.w;
  return leaving;
}

Begin BeginOnTriangle(MarchState state) {
  Begin begin;
  begin.w = HitWeights(state);
  begin.w_apex = 0.0;
  begin.z = AtHit(begin.w, state, p.z);
  begin.density = AtHit(begin.w, state, density);
  begin.payload = AtHit(begin.w, state, payload);
  return begin;
}

// The frame's origin is the camera: its weights are ratios of the volumes of the tets that it forms
// with the faces.
Begin BeginAtCamera(MarchState state, Corner apex) {
  vec3 a = state.a.p, b = state.b.p, c = state.c.p, d = apex.p;
  vec4 volumes = vec4(dot(b, cross(d, c)), dot(a, cross(c, d)), dot(a, cross(d, b)), dot(a, cross(b, c)));
  volumes = max(sign(dot(b - a, cross(d - a, c - a))) * volumes, vec4(0.0));
  float sum = volumes.x + volumes.y + volumes.z + volumes.w;
  volumes = sum > 0.0 ? volumes / sum : vec4(0.25);
  Begin begin;
  begin.w = volumes.xyz;
  begin.w_apex = volumes.w;
  begin.z = 0.0;
  begin.density = AtHit(begin.w, state, density) + begin.w_apex * apex.density;
  begin.payload = AtHit(begin.w, state, payload) + begin.w_apex * apex.payload;
  return begin;
}

// How a ray entered the mesh; x: hull face, or kMiss; y: how far the origin is moved, as bits.
#define Entry uvec2
const Entry kNoEntry = Entry(kMiss, 0u);

// Starts the ray in its camera's tet, or at its entry into the mesh. For the latter the ray's
// origin is moved close to the mesh, so that the precision of coordinates is relative to the size
// of the mesh.
void BeginMarch(inout Ray ray, Entry entry, bool go, inout MarchState state, inout Begin begin) {
  TETREC_RARELY(go && ray.start_tet != kNoTet) {
    state = EnterFromInside(ray, ray.start_tet);
    begin = BeginAtCamera(state, FetchApex(ray, state, texelFetch(tets, int(2u * ray.start_tet))));
  }
  TETREC_RARELY(go && ray.start_tet == kNoTet) {
    ray.origin += uintBitsToFloat(entry.y) * ray.direction;
    state = EnterThroughFace(ray, entry.x);
    begin = BeginOnTriangle(state);
  }
}

// The entries of a ray that starts at `entry`.
Entries EntriesFrom(Ray ray, Entry entry, MarchState state) {
  return EntriesBehind(
      ray.start_tet != kNoTet
          ? Crossing(-CameraRounding(ray), 0u)
          : Crossing(HitDistance(state.e, state.a.p, state.b.p, state.c.p), entry.x));
}

// Lets a ray that has left the mesh enter it again; false if it never does.
bool EnterAgain(Ray ray, inout Entries entries, inout MarchState state, inout Begin begin) {
  uint face = TakeEntry(ray, entries);
  TETREC_RARELY(face != kMiss) {
    state = EnterThroughFace(ray, face);
    begin = BeginOnTriangle(state);
  }
  return face != kMiss;
}
