// Where a ray enters a mesh of any shape: holes, cavities, several parts.
//
// Which faces the line enters by is decided by the signs of edge functions, as in the march itself:
// in one frame a ray, by the same floats. So every way of the line through the mesh, from a face that
// it enters by to one that it leaves by, is walked once: a ray takes the entering faces in the order
// of (distance, number), each greater than the last, and cannot circle. Rounding can only err in
// distances: where two ways overlap by that, the later one counts from the end of the one before.
//
// The including kernel declares `hull`, `push`, PlaceInRayFrame.

// An entering face; a ray takes them in the order of z, of equal ones in that of the numbers.
struct Crossing {
  float z;
  uint face;  // or kMiss
};

const float kNoDistance = 3.0e38;

// What a ray knows of its entries: those found ahead, in order (kMiss: none), and the last one taken.
struct Entries {
  vec4 z;
  uvec4 face;
  Crossing last;
  bool more;      // there may be others behind those found
  bool is_whole;  // no search was cut short
};

Entries EntriesBehind(Crossing last) {
  return Entries(vec4(kNoDistance), uvec4(kMiss), last, true, true);
}

bool MayEnter(Entries entries) { return entries.more || entries.face.x != kMiss; }

// Whether the ray has the way from a to b on its left. Of equal products the coordinates decide, as
// if the ray were moved by (t, t^2), t -> 0: a shared edge belongs to one of its faces.
bool LeftOf(vec3 a, vec3 b) {
  precise float p = a.x * b.y;
  precise float q = a.y * b.x;
  return p != q ? p > q : a.y != b.y ? a.y > b.y : b.x > a.x;
}

// Distance of the point that edge functions e weigh.
float HitDistance(vec3 e, vec3 a, vec3 b, vec3 c) {
  precise vec3 w = max(e, vec3(0.0));
  precise float sum = w.x + w.y + w.z;
  precise float z = w.x * a.z + w.y * b.z + w.z * c.z;
  return sum > 0.0 ? z / sum : min(a.z, min(b.z, c.z));
}

// Puts a crossing in its place; the last of those found before may fall out.
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

// Adds face `face` where the ray enters by it behind the last entry taken.
void Consider(Ray ray, uint face, inout Entries entries) {
  vec4 plane = texelFetch(hull, int(2u * face));
  // Faces that turn their backs beyond all rounding need no look.
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

// The next entries behind the last one taken. Walks over the tree of boxes, nearer child first, so
// that what lies behind the entries found is cut off.
void FindEntries(Ray ray, inout Entries entries) {
  vec3 d = ray.direction;
  vec3 slope = 1.0 / mix(d, vec3(1e-18), lessThan(abs(d), vec3(1e-18)));
  uint node = 1u;
  uint trail = 0u;  // a bit a level, the lowest of the node's own: whether its sibling is done
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
      // Up past all nodes whose sibling is done, then to the sibling; from the root: to none.
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

// Takes the next face by which the line enters; kMiss where there is none.
uint TakeEntry(Ray ray, inout Entries entries) {
  TETREC_RARELY(entries.face.x == kMiss && entries.more) { FindEntries(ray, entries); }
  uint face = entries.face.x;
  if (face != kMiss) entries.last = Crossing(entries.z.x, face);
  entries.z = vec4(entries.z.yzw, kNoDistance);
  entries.face = uvec4(entries.face.yzw, kMiss);
  return face;
}

// Farther behind the camera than this lies no face that a camera outside the mesh could enter by.
float CameraRounding(Ray ray) {
  vec3 size = abs(ray.origin) + abs(push.mesh_ball.xyz) + push.mesh_ball.w;
  return 1e-6 * max(size.x, max(size.y, size.z));
}

// How far a ray's frame is moved along it: to where the mesh's ball may begin, so that coordinates
// are as precise as the mesh is small.
float FrameBegin(Ray ray) {
  return max(dot(push.mesh_ball.xyz - ray.origin, ray.direction) - push.mesh_ball.w, 0.0);
}
