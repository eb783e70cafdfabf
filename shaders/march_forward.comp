// Forward pass: colour before the background and optical depth of every ray. With TETREC_DEPTH also
// the distance from the camera at which the optical depth reaches the stop depth, 0 where it never
// does: the last segment contains that place, so nothing more is computed inside the loops.
#version 460
#extension GL_GOOGLE_include_directive : require

#define Payload vec3
#define MakePayload(color) (color)
#include "march.glsl"

layout(std430, binding = kBindRayColors) writeonly buffer RayColors { vec4 ray_colors[]; };
layout(std430, binding = kBindRayEntries) writeonly buffer RayEntries { Entry ray_entries[]; };
#ifdef TETREC_DEPTH
layout(std430, binding = kBindRayReaches) writeonly buffer RayReaches { float ray_reaches[]; };
#endif

void main() {
  uint index = gl_GlobalInvocationID.x;
  bool exists = index < push.rays.ray_count;
  Ray ray = MakeRay(exists ? index : 0u);
  g_first_color = ray.slot * push.row_count;
  bool go = exists && ray.valid;
  bool inside = ray.start_tet != kNoTet;
  Entry entry = kNoEntry;
  Chord chord = Chord(0.0, 0.0, 0u, 1.0);
  Entries entries = EntriesBehind(Crossing(-CameraRounding(ray), 0u));
  MarchState state;
  Begin begin;
  state.tet = kNoTet;
  TETREC_RARELY(go && !inside) {
    if (kAnyBoundary != 0) {
      float frame = FrameBegin(ray);
      Ray at_mesh = ray;
      at_mesh.origin += frame * ray.direction;
      entry = Entry(TakeEntry(at_mesh, entries), floatBitsToUint(frame));
      go = entry.x != kMiss;
    } else {
      chord = FindChord(ray);
      go = chord.begin <= chord.end && chord.begin >= 0.0;
      TETREC_RARELY(go) {
        Ray at_hull = ray;
        at_hull.origin += chord.begin * ray.direction;
        // A few roundings of coordinates as large as the distance to the far side of the hull.
        uint face = FindEntryFace(at_hull, chord.entry_plane, 4e-6 * chord.end);
        entry = Entry(face, floatBitsToUint(chord.begin));
        go = entry.x != kMiss;
      }
    }
  }
  bool hit = go;
  BeginMarch(ray, entry, go, state, begin);

  vec3 color = vec3(0.0);
  float depth = 0.0;  // optical
  uint steps = 0u;
  bool strays = false;  // left the mesh through a face that does not contain the ray
  float z0 = begin.z;
  float density0 = begin.density;
  vec3 color0 = begin.payload;
#ifdef TETREC_DEPTH
  float last_z0 = 0.0, last_size = 0.0, last_s0 = 0.0, last_s1 = 0.0;
#endif
  while (go) {
    // Thick segments are integrated outside the inner loop, which they would slow down for all rays.
    bool thick = false;
    float s0 = 0.0, s1 = 0.0;
    vec3 color_at0 = vec3(0.0), color_at1 = vec3(0.0);  // colours at the ends of the part that the cut leaves
    while (go && !thick) {
      uint tet = state.tet;
      uvec4 ids = texelFetch(tets, int(2u * tet));
      uvec4 neighbors = texelFetch(tets, int(2u * tet + 1u));
      StepThrough(state, FetchApex(ray, state, ids), ids, neighbors);
      vec3 w = HitWeights(state);
      float z1 = max(z0, AtHit(w, state, p.z));
      float density1 = AtHit(w, state, density);
      vec3 color1 = AtHit(w, state, payload);
      UseCell(tet, density0, density1, color0, color1);
      SegmentCut cut = CutAtZero(density0, density1);
      float size = (cut.end - cut.begin) * (z1 - z0);
      s0 = DensityOf(density0) * size;
      s1 = DensityOf(density1) * size;
      color_at0 = mix(color0, color1, cut.begin);
      color_at1 = mix(color0, color1, cut.end);
#ifdef TETREC_DEPTH
      last_z0 = mix(z0, z1, cut.begin);
      last_size = size;
      last_s0 = s0;
      last_s1 = s1;
#endif
      thick = IsThickSegment(kIntegral, s0, s1);
      if (!thick) {
        SegmentWeights segment = IntegrateUnlessThick(kIntegral, kSplits, s0, s1);
        color += exp(-depth) * (segment.w0 * color_at0 + segment.w1 * color_at1);
        depth += 0.5 * (s0 + s1);
      }
      z0 = z1;
      density0 = density1;
      color0 = color1;
      steps += 1u;
      go = state.tet != kNoTet && depth < push.rays.stop_depth && steps < push.max_steps;
    }
    if (thick) {
      SegmentWeights segment = IntegrateThickSegment(s0, s1);
      color += exp(-depth) * (segment.w0 * color_at0 + segment.w1 * color_at1);
      depth += 0.5 * (s0 + s1);
      go = go && depth < push.rays.stop_depth;
    }
    if (kAnyBoundary != 0) {
      TETREC_RARELY(hit && MayEnter(entries) && state.tet == kNoTet && depth < push.rays.stop_depth &&
                    steps < push.max_steps) {
        strays = strays || Least(state.e) < 0.0;
        go = EnterAgain(ray, entries, state, begin);
        if (go) {
          z0 = max(z0, begin.z);
          density0 = begin.density;
          color0 = begin.payload;
        }
      }
    }
  }

  strays = strays || (hit && state.tet == kNoTet && Least(state.e) < 0.0);  // at the last exit
  if (exists) {
    ray_colors[index] = vec4(color, depth);
    ray_entries[index] = entry;
  }
  // A ray that did not stop early must have left the mesh. A convex hull is left where it ends, up to
  // roundings of coordinates, which a face seen at a flat angle stretches along the ray; any other
  // boundary through faces that contain the ray, until a complete search found no entry.
  bool stopped = depth >= push.rays.stop_depth;
#ifdef TETREC_DEPTH
  if (exists) {
    float before = max(depth - 0.5 * (last_s0 + last_s1), 0.0);
    float share = ReachInSegment(last_s0, last_s1, push.rays.stop_depth - before);
    float reach = (inside ? 0.0 : uintBitsToFloat(entry.y)) + last_z0 + share * last_size;
    ray_reaches[index] = hit && stopped ? reach : 0.0;
  }
#endif
  float length = chord.end - chord.begin;
  float rounding = 1e-3 * (length + z0) + 8e-6 * chord.end / chord.exit_cosine;
  bool astray = !inside && (kAnyBoundary != 0 ? strays : abs(z0 - length) > rounding);
  bool lost = !entries.is_whole || (hit && !stopped && (state.tet != kNoTet || astray));
  if (lost) atomicAdd(counters[kCounterLostRays], 1u);
#ifdef TETREC_COUNT_STEPS
  atomicAdd(counters[kCounterSteps], steps);
  if (hit) atomicAdd(counters[kCounterHitRays], 1u);
#endif
}
