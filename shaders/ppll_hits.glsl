// Reading sorted lists: where a ray passes a face, and which tets lie before and behind it.
//
// Between two hits next to one another lies one tet: that behind the first is that before the second.
// Where rounding has swapped hits that all but coincide (at edges, at vertices, in slivers), the two
// differ; the field being continuous, the values at the two hits are right all the same. There is
// nothing in between where the first face leaves the mesh or the second enters it: a gap.
//
// The including kernel defines Payload and MakePayload(color) as for march.glsl.
#include "ppll.glsl"

layout(local_size_x = kWorkgroupSize) in;

layout(std430, binding = kBindLists) readonly buffer Lists { uvec2 lists[]; };
layout(std430, binding = kBindFragments) readonly buffer Fragments { uvec2 fragments[]; };

struct Hit {
  float z;
  uint before, behind;  // tets, or kNoTet
  float density;
  Payload payload;
  uvec4 ids;  // of vertices
  vec4 w;     // their weights; of a face only three
};

Hit HitAt(Ray ray, uvec2 fragment) {
  uint tet = fragment.y >> 3, i = fragment.y >> 1 & 3u;
  uvec4 neighbors = texelFetch(tets, int(2u * tet + 1u));
  uint other = i == 0u ? neighbors.x : i == 1u ? neighbors.y : i == 2u ? neighbors.z : neighbors.w;
  bool enters = (fragment.y & 1u) != 0u;
  uvec3 ids = FaceVertices(texelFetch(tets, int(2u * tet)), i);
  vec4 a = texelFetch(vertices, int(2u * ids.x)), b = texelFetch(vertices, int(2u * ids.y));
  vec4 c = texelFetch(vertices, int(2u * ids.z));
  vec3 w = HitWeights(InRayFrame(ray, a.xyz), InRayFrame(ray, b.xyz), InRayFrame(ray, c.xyz));
  Hit hit;
  hit.z = uintBitsToFloat(fragment.x);
  hit.before = enters ? other : tet;
  hit.behind = enters ? tet : other;
  hit.density = w.x * a.w + w.y * b.w + w.z * c.w;
  hit.payload = w.x * MakePayload(FetchVertexColor(ids.x)) +
                w.y * MakePayload(FetchVertexColor(ids.y)) +
                w.z * MakePayload(FetchVertexColor(ids.z));
  hit.ids = uvec4(ids, ids.x);
  hit.w = vec4(w, 0.0);
  return hit;
}

// The camera in tet `tet`, as a hit behind which the tet lies. Weights are ratios of the volumes of
// the tets that the camera forms with the faces.
Hit HitAtCamera(ListRay list_ray, uint tet) {
  uvec4 ids = texelFetch(tets, int(2u * tet));
  vec4 row_a = texelFetch(vertices, int(2u * ids.x)), row_b = texelFetch(vertices, int(2u * ids.y));
  vec4 row_c = texelFetch(vertices, int(2u * ids.z)), row_d = texelFetch(vertices, int(2u * ids.w));
  vec3 origin = list_ray.ray.origin;
  vec3 a = row_a.xyz - origin, b = row_b.xyz - origin, c = row_c.xyz - origin, d = row_d.xyz - origin;
  vec4 w = vec4(dot(b, cross(c, d)), dot(a, cross(d, c)), dot(a, cross(b, d)), dot(a, cross(c, b)));
  w = max(w, vec4(0.0));
  float sum = w.x + w.y + w.z + w.w;
  Hit hit;
  hit.z = list_ray.camera_z;
  hit.before = kNoTet;
  hit.behind = tet;
  hit.ids = ids;
  hit.w = sum > 0.0 ? w / sum : vec4(0.25);
  hit.density = dot(hit.w, vec4(row_a.w, row_b.w, row_c.w, row_d.w));
  hit.payload = hit.w.x * MakePayload(FetchVertexColor(ids.x)) +
                hit.w.y * MakePayload(FetchVertexColor(ids.y)) +
                hit.w.z * MakePayload(FetchVertexColor(ids.z)) +
                hit.w.w * MakePayload(FetchVertexColor(ids.w));
  return hit;
}

// What a ray has before its first fragment: nothing, or its camera in the tet before that.
Hit HitBeforeFirst(ListRay list_ray, Hit first) {
  Hit hit = first;
  hit.behind = kNoTet;
  TETREC_RARELY(list_ray.ray.start_tet != kNoTet && first.before != kNoTet) {
    hit = HitAtCamera(list_ray, first.before);
  }
  return hit;
}
