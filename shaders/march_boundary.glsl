// Where a ray enters a mesh of any shape: with holes, cavities, several parts.
//
// The signs of edge functions decide through which faces the line enters, as in the march itself:
// from the same floats, in the same frame of the ray. So every stretch of the line inside the mesh,
// from a face where it enters to one where it leaves, is walked once: a ray takes the entering
// faces in ascending order of (distance, number) and cannot circle. Rounding affects distances
// only: if two stretches overlap because of it, the later one counts from the end of the earlier
// one.
//
// The including kernel declares `hull`, `push`, PlaceInRayFrame.

// An entering face. A ray takes them in the order of z, and of their numbers if z is equal.
struct Crossing {
  float z;
  uint face;  // or kMiss
};

const float kNoDistance = 3.0e38;

// The entries of a ray: those found ahead, in order (kMiss: none), and the last one taken.
struct Entries {
  vec4 z;
  uvec4 face;
  Crossing last;
  bool more;      // there may be more behind those found
  bool is_whole;  // no search was cut short
};

Entries EntriesBehind(Crossing last) {
  return Entries(vec4(kNoDistance), uvec4(kMiss), last, true, true);
}

bool MayEnter(Entries entries) { return entries.more || entries.face.x != kMiss; }

// True if the edge from a to b is on the ray's left. If the products are equal, the coordinates
// decide, as if the ray were moved by (t, t^2), t -> 0: a shared edge belongs to one of its faces.
bool LeftOf(vec3 a, vec3 b) {
  precise float p = a.x * b.y;
  precise float q = a.y * b.x;
  return p != q ? p > q : a.y != b.y ? a.y > b.y : b.x > a.x;
}

// Distance of the point whose weights are the edge functions e.
float HitDistance(vec3 e, vec3 a, vec3 b, vec3 c) {
  precise vec3 w = max(e, vec3(0.0));
  precise float sum = w.x + w.y + w.z;
  precise float z = w.x * a.z + w.y * b.z + w.z * c.z;
  return sum > 0.0 ? z / sum : min(a.z, min(b.z, c.z));
}

// Inserts a crossing in order; the last of those found before may drop out.
void Insert(inout Entries entries, Crossing here) {
  bvec4 before = bvec4(false);
  before.x = here.z < entries.z.x || (here.z == entries.z.x && here.face < entries.face.x);
  before.y = here.z < entries.z.y || (here.z == entries.z.y && here.face < entries.face.y);
  before.z = here.z < entries.z.z || (here.z == entries.z.z && here.face < entries.face.z);
  before.w = here.z < entries.z.w || (here.z == entries.z.w && here.face < entries.face.w);
  vec4 z = mix(entries.z, vec4(here.z), before);
  uvec4 face = mix(entries.face, uvec4(here.face), before);
  z.yzw = mix(z.yzw, entries.z.xyz, before.xyz);
  face.yzw = mix(face.yzw, entries.face.xyz, before.xyz);
  entries.z = z;
  entries.face = face;
}

// Adds face `face` if the ray enters through it behind the last entry taken.
void Consider(Ray ray, uint face, inout Entries entries) {
  vec4 plane = texelFetch(hull, int(2u * face));
  // Faces that are turned away, beyond any rounding, are skipped.
  TETREC_RARELY(dot(plane.xyz, ray.direction) < 1e-3) {
    uvec4 ids = floatBitsToUint(texelFetch(hull, int(2u * face + 1u)));
    vec3 a = PlaceInRayFrame(ray, ids.x), b = PlaceInRayFrame(ray, ids.y);
    vec3 c = PlaceInRayFrame(ray, ids.z);
    Crossing here = Crossing(0.0, face);
    here.z = HitDistance(vec3(EdgeFunction(b, c), EdgeFunction(c, a), EdgeFunction(a, b)), a, b, c);
    Crossing last = entries.last;
    bool is_behind = here.z > last.z || (here.z == last.z && here.face > last.face);
    if (is_behind && LeftOf(b, c) && LeftOf(c, a) && LeftOf(a, b)) Insert(entries, here);
  }
}

// Finds the next entries behind the last one taken. Walks the tree of boxes, nearer child first, so
// that boxes behind the entries found are skipped.
void FindEntries(Ray ray, inout Entries entries) {
  vec3 d = ray.direction;
  vec3 slope = 1.0 / mix(d, vec3(1e-18), lessThan(abs(d), vec3(1e-18)));
  uint node = 1u;
  uint trail = 0u;  // one bit per level, the lowest for the node's own: its sibling is done
  while (node != 0u) {
    // All rays of a group look for their next leaf before any tries its faces.
    uvec2 leaf = uvec2(kMiss);
    while (node != 0u && leaf.x == kMiss) {
      int row = int(2u * (push.hull_faces + node));
      vec4 low = texelFetch(hull, row), high = texelFetch(hull, row + 1);
      vec3 to_low = (low.xyz - ray.origin) * slope, to_high = (high.xyz - ray.origin) * slope;
      vec3 near = min(to_low, to_high), far = max(to_low, to_high);
      float begin = max(near.x, max(near.y, near.z)), end = min(far.x, min(far.y, far.z));
      bool is_met = begin <= end && end >= entries.last.z && begin <= entries.z.w;
      bool is_leaf = node >= push.tree_leaves;
      if (is_met && is_leaf) leaf = floatBitsToUint(vec2(low.w, high.w));
      bool down = is_met && !is_leaf;
      uint axis = floatBitsToUint(low.w);
      uint backwards = (axis == 0u ? d.x : axis == 1u ? d.y : d.z) < 0.0 ? 1u : 0u;
      // Goes up past all nodes whose sibling is done, then to the sibling; from the root to none.
      uint up = uint(findLSB(~trail));
      uint sibling = (node >> up) ^ 1u;
      node = down ? 2u * node + backwards : sibling;
      trail = down ? trail << 1u : (trail >> up) | 1u;
    }
    if (leaf.x != kMiss) Consider(ray, leaf.x, entries);
    if (leaf.x != leaf.y) Consider(ray, leaf.y, entries);
  }
  entries.is_whole = entries.is_whole && node == 0u;
  entries.more = entries.face.w != kMiss;
}

// Takes the next face through which the line enters; kMiss if there is none.
uint TakeEntry(Ray ray, inout Entries entries) {
  TETREC_RARELY(entries.face.x == kMiss && entries.more) { FindEntries(ray, entries); }
  uint face = entries.face.x;
  if (face != kMiss) entries.last = Crossing(entries.z.x, face);
  entries.z = vec4(entries.z.yzw, kNoDistance);
  entries.face = uvec4(entries.face.yzw, kMiss);
  return face;
}

// No face through which the ray of a camera outside the mesh enters is farther behind the camera.
float CameraRounding(Ray ray) {
  vec3 size = abs(ray.origin) + abs(push.mesh_ball.xyz) + push.mesh_ball.w;
  return 1e-6 * max(size.x, max(size.y, size.z));
}

// How far a ray's frame is moved along it: to where the mesh's ball may start, so that the
// precision of coordinates is relative to the size of the mesh.
float FrameBegin(Ray ray) {
  return max(dot(push.mesh_ball.xyz - ray.origin, ray.direction) - push.mesh_ball.w, 0.0);
}
