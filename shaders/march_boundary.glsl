// Where a ray enters a mesh of any shape: holes, cavities, several parts.
//
// Which faces the line enters by is decided by the signs of edge functions, as in the march itself:
// in one frame a ray, by the same floats. So every way of the line through the mesh, from a face that
// it enters by to one that it leaves by, is walked once: a ray takes the entering faces in the order
// of (distance, number), each greater than the last, and cannot circle. Rounding can only err in
// distances: where two ways overlap by that, the later one counts from the end of the one before.
//
// The including kernel declares `hull`, `push`, PlaceInRayFrame.

// An entering face, in the order in which a ray takes them.
struct Crossing {
  float z;
  uint face;  // or kMiss
};

bool IsBefore(Crossing a, Crossing b) { return a.z < b.z || (a.z == b.z && a.face < b.face); }

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

float EdgeFunction(vec3 from, vec3 to) {
  precise float e = from.x * to.y - from.y * to.x;
  return e;
}

// `best`, or face `face` where the ray enters by it behind `last` and before `best`.
Crossing NearerEntry(Ray ray, uint face, Crossing last, Crossing best) {
  Crossing result = best;
  vec4 plane = texelFetch(hull, int(2u * face));
  // Faces that turn their backs beyond all rounding need no look.
  TETREC_RARELY(dot(plane.xyz, ray.direction) < 1e-3) {
    uvec4 ids = floatBitsToUint(texelFetch(hull, int(2u * face + 1u)));
    vec3 a = PlaceInRayFrame(ray, ids.x), b = PlaceInRayFrame(ray, ids.y);
    vec3 c = PlaceInRayFrame(ray, ids.z);
    Crossing here = Crossing(0.0, face);
    here.z = HitDistance(vec3(EdgeFunction(b, c), EdgeFunction(c, a), EdgeFunction(a, b)), a, b, c);
    bool enters = LeftOf(b, c) && LeftOf(c, a) && LeftOf(a, b);
    if (enters && IsBefore(last, here) && IsBefore(here, best)) result = here;
  }
  return result;
}

// The face by which the line enters next behind `last`; kMiss where there is none. Walks over the
// tree of boxes, nearer child first, so that what lies behind the nearest entry so far is cut off.
// `is_whole` turns false where the walk was cut short.
Crossing NextEntry(Ray ray, Crossing last, inout bool is_whole) {
  vec3 d = ray.direction;
  vec3 slope = 1.0 / mix(d, vec3(1e-18), lessThan(abs(d), vec3(1e-18)));
  Crossing best = Crossing(3.0e38, kMiss);
  uint node = 1u;
  uint trail = 0u;  // a bit a level, the lowest of the node's own: whether its sibling is done
  while (node != 0u) {
    int row = int(2u * (push.hull_faces + node));
    vec4 low = texelFetch(hull, row), high = texelFetch(hull, row + 1);
    vec3 to_low = (low.xyz - ray.origin) * slope, to_high = (high.xyz - ray.origin) * slope;
    vec3 near = min(to_low, to_high), far = max(to_low, to_high);
    float begin = max(near.x, max(near.y, near.z)), end = min(far.x, min(far.y, far.z));
    bool is_met = begin <= end && end >= last.z && begin <= best.z;
    bool is_leaf = node >= push.tree_leaves;
    TETREC_RARELY(is_met && is_leaf) {
      uint first = floatBitsToUint(low.w), second = floatBitsToUint(high.w);
      best = NearerEntry(ray, first, last, best);
      TETREC_RARELY(second != first) { best = NearerEntry(ray, second, last, best); }
    }
    bool down = is_met && !is_leaf;
    uint axis = floatBitsToUint(low.w);
    uint backwards = (axis == 0u ? d.x : axis == 1u ? d.y : d.z) < 0.0 ? 1u : 0u;
    // Up past all nodes whose sibling is done, then to the sibling; from the root: to none.
    uint up = uint(findLSB(~trail));
    uint sibling = (node >> up) ^ 1u;
    node = down ? 2u * node + backwards : sibling;
    trail = down ? trail << 1u : (trail >> up) | 1u;
  }
  is_whole = is_whole && node == 0u;
  return best;
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
