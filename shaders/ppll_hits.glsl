// Reading sorted lists: where a ray passes a face, and which tets are before and behind it.
//
// There is one tet between two consecutive hits: the one behind the first is the one before the
// second. If rounding has swapped hits that almost coincide (at edges, at vertices, in slivers),
// the two differ; since a field on vertices is continuous, the values at the two hits are right all
// the same. If the first face leaves the mesh or the second enters it, there is nothing in between:
// a gap.
//
// The including kernel includes ppll.glsl, and for TETREC_POSITIONS gradients.glsl, and defines
// Payload and MakePayload(color) as for march.glsl.

layout(local_size_x = kWorkgroupSize) in;

layout(std430, binding = kBindLists) readonly buffer Lists { uvec2 lists[]; };
layout(std430, binding = kBindFragments) readonly buffer Fragments { uvec2 fragments[]; };

struct Hit {
  float z;
  uint before, behind;  // tets, or kNoTet
  float density;
  Payload payload;
  uvec4 ids;  // of vertices; of a face only three, then kNoVertex
  vec4 w;     // their weights
#ifdef TETREC_POSITIONS
  Slopes slopes;
#endif
};

Hit HitAt(Ray ray, uvec2 fragment) {
  uint tet = fragment.y >> 3, i = fragment.y >> 1 & 3u;
  uvec4 neighbors = texelFetch(tets, int(2u * tet + 1u));
  uint other = i == 0u ? neighbors.x : i == 1u ? neighbors.y : i == 2u ? neighbors.z : neighbors.w;
  bool enters = (fragment.y & 1u) != 0u;
  uvec3 ids = FaceVertices(texelFetch(tets, int(2u * tet)), i);
  vec4 a = texelFetch(vertices, int(2u * ids.x)), b = texelFetch(vertices, int(2u * ids.y));
  vec4 c = texelFetch(vertices, int(2u * ids.z));
  vec3 p_a = InRayFrame(ray, a.xyz), p_b = InRayFrame(ray, b.xyz), p_c = InRayFrame(ray, c.xyz);
  Payload k_a = MakePayload(FetchVertexColor(ids.x));
  Payload k_b = MakePayload(FetchVertexColor(ids.y));
  Payload k_c = MakePayload(FetchVertexColor(ids.z));
  vec3 w = HitWeights(p_a, p_b, p_c);
  Hit hit;
  hit.z = uintBitsToFloat(fragment.x);
  hit.before = enters ? other : tet;
  hit.behind = enters ? tet : other;
  hit.density = w.x * a.w + w.y * b.w + w.z * c.w;
  hit.payload = w.x * k_a + w.y * k_b + w.z * k_c;
  hit.ids = uvec4(ids, kNoVertex);
  hit.w = vec4(w, 0.0);
#ifdef TETREC_POSITIONS
  hit.slopes = SlopesOnFace(FaceCorners(p_a, p_b, p_c, vec3(a.w, b.w, c.w), vec3(k_a, k_b, k_c)),
                            EdgeFunctions(p_a, p_b, p_c));
#endif
  return hit;
}

// Volumes of the tets that the origin forms with the faces of a tet, by opposite vertex:
// proportional to its barycentric weights.
vec4 VolumesAtOrigin(vec3 a, vec3 b, vec3 c, vec3 d) {
  return vec4(dot(b, cross(c, d)), dot(a, cross(d, c)), dot(a, cross(b, d)), dot(a, cross(c, b)));
}

// The camera in tet `tet`, as a hit with the tet behind it.
Hit HitAtCamera(ListRay list_ray, uint tet) {
  uvec4 ids = texelFetch(tets, int(2u * tet));
  vec4 row_a = texelFetch(vertices, int(2u * ids.x)), row_b = texelFetch(vertices, int(2u * ids.y));
  vec4 row_c = texelFetch(vertices, int(2u * ids.z)), row_d = texelFetch(vertices, int(2u * ids.w));
  vec3 origin = list_ray.ray.origin;
  vec3 a = row_a.xyz - origin, b = row_b.xyz - origin, c = row_c.xyz - origin, d = row_d.xyz - origin;
  vec4 w = max(VolumesAtOrigin(a, b, c, d), vec4(0.0));
  float sum = w.x + w.y + w.z + w.w;
  Hit hit;
  hit.z = list_ray.camera_z;
  hit.before = kNoTet;
  hit.behind = tet;
  hit.ids = ids;
  hit.w = sum > 0.0 ? w / sum : vec4(0.25);
  vec4 density = vec4(row_a.w, row_b.w, row_c.w, row_d.w);
  Payload k_a = MakePayload(FetchVertexColor(ids.x));
  Payload k_b = MakePayload(FetchVertexColor(ids.y));
  Payload k_c = MakePayload(FetchVertexColor(ids.z));
  Payload k_d = MakePayload(FetchVertexColor(ids.w));
  hit.density = dot(hit.w, density);
  hit.payload = hit.w.x * k_a + hit.w.y * k_b + hit.w.z * k_c + hit.w.w * k_d;
#ifdef TETREC_POSITIONS
  hit.slopes = SlopesInTet(InRayFrame(list_ray.ray, row_a.xyz), InRayFrame(list_ray.ray, row_b.xyz),
                           InRayFrame(list_ray.ray, row_c.xyz), InRayFrame(list_ray.ray, row_d.xyz),
                           density, vec4(k_a, k_b, k_c, k_d));
#endif
  return hit;
}

// The smallest barycentric weight in a tet of the ray's point at z.
float LeastWeight(ListRay list_ray, float z, uint tet) {
  uvec4 ids = texelFetch(tets, int(2u * tet));
  vec3 point = list_ray.ray.origin + z * list_ray.ray.direction;
  vec3 a = texelFetch(vertices, int(2u * ids.x)).xyz - point;
  vec3 b = texelFetch(vertices, int(2u * ids.y)).xyz - point;
  vec3 c = texelFetch(vertices, int(2u * ids.z)).xyz - point;
  vec3 d = texelFetch(vertices, int(2u * ids.w)).xyz - point;
  vec4 w = VolumesAtOrigin(a, b, c, d);
  return min(min(w.x, w.y), min(w.z, w.w)) / (w.x + w.y + w.z + w.w);
}

// The cell between two hits. Cells are not continuous: if swapped hits disagree, it is the one
// that contains the middle.
uint TetBetween(ListRay list_ray, Hit hit0, Hit hit1) {
  uint tet = hit0.behind;
  if (kCells) {
    TETREC_RARELY(hit0.behind != hit1.before) {
      float middle = 0.5 * (hit0.z + hit1.z);
      bool other = LeastWeight(list_ray, middle, hit1.before) > LeastWeight(list_ray, middle, tet);
      tet = other ? hit1.before : tet;
    }
  }
  return tet;
}

// What is before a ray's first fragment: nothing, or the camera in the tet before that fragment.
Hit HitBeforeFirst(ListRay list_ray, Hit first) {
  Hit hit = first;
  hit.behind = kNoTet;
  TETREC_RARELY(list_ray.ray.start_tet != kNoTet && first.before != kNoTet) {
    hit = HitAtCamera(list_ray, first.before);
  }
  return hit;
}
