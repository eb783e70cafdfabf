// Cuts a ray with a tet, without cracks or overlaps between neighbours.
//
// In the ray's frame (march.glsl) the ray is the origin of the plane and a vertex is a point (x, y)
// of it with a depth z. The origin is left or right of each of the six edges. The sign of E(a, b) =
// a.x b.y - a.y b.x is decided exactly for the float coordinates, and if it is 0, for an origin
// moved by (t, t^2), t -> 0+. So the four points are in general position for every ray, and the ray
// crosses exactly two faces of the tet or none; the two tets at a face decide by the same numbers.
// A ray inside a mesh without holes is therefore covered once.
//
// The including kernel declares `tets`, `vertices`, `push.start`.
#include "exact.glsl"

struct TetCut {
  bool hit;
  float z0, z1;        // along the ray, from its origin
  vec4 w0, w1;         // barycentric weights of the two ends
  bvec4 face0, face1;  // the vertex that the face of an end lacks
  bool at_camera;      // the first end is the camera, not on face0
  uvec4 ids;
  vec3 a, b, c, d;  // the vertices in the ray's frame
  vec4 density;     // of the vertices
};

struct Edge {
  float e;    // |E(a, b)|
  bool left;  // its sign; wrong only where it is tied
  bool tied;  // the products are equal floats
};

Edge MakeEdge(vec3 a, vec3 b) {
  precise float p = a.x * b.y;
  precise float q = a.y * b.x;
  return Edge(abs(EdgeFunction(a, b)), p > q, p == q);
}

// Rounding is monotonic: products that differ as floats are in the order of the true ones. If they
// are equal, the rounding errors decide; if the true ones are equal too, the moved origin decides.
bool BreakTie(Edge edge, vec3 a, vec3 b) {
  float p_rest = ProductError(a.x, b.y, a.x * b.y), q_rest = ProductError(a.y, b.x, a.y * b.x);
  bool left = p_rest != q_rest ? p_rest > q_rest : a.y != b.y ? a.y > b.y : b.x > a.x;
  return edge.tied ? left : edge.left;
}

// Weights of the point where the ray meets a face, from the edges opposite its vertices; `opposite`
// is 1 for the vertex that is not on the face.
vec4 FaceWeights(vec4 e, vec4 opposite) {
  float sum = e.x + e.y + e.z + e.w;
  return sum > 0.0 ? e * (1.0 / sum) : (vec4(1.0) - opposite) * (1.0 / 3.0);
}

TetCut CutTet(Ray ray, uint tet) {
  TetCut cut;
  cut.ids = texelFetch(tets, int(2u * tet));
  vec4 v0 = texelFetch(vertices, int(2u * cut.ids.x)), v1 = texelFetch(vertices, int(2u * cut.ids.y));
  vec4 v2 = texelFetch(vertices, int(2u * cut.ids.z)), v3 = texelFetch(vertices, int(2u * cut.ids.w));
  cut.density = vec4(v0.w, v1.w, v2.w, v3.w);
  vec3 a = InRayFrame(ray, v0.xyz), b = InRayFrame(ray, v1.xyz);
  vec3 c = InRayFrame(ray, v2.xyz), d = InRayFrame(ray, v3.xyz);
  cut.a = a, cut.b = b, cut.c = c, cut.d = d;
  Edge ab = MakeEdge(a, b), ac = MakeEdge(a, c), ad = MakeEdge(a, d);
  Edge bc = MakeEdge(b, c), bd = MakeEdge(b, d), cd = MakeEdge(c, d);
  TETREC_RARELY(ab.tied || ac.tied || ad.tied || bc.tied || bd.tied || cd.tied) {
    ab.left = BreakTie(ab, a, b);
    ac.left = BreakTie(ac, a, c);
    ad.left = BreakTie(ad, a, d);
    bc.left = BreakTie(bc, b, c);
    bd.left = BreakTie(bd, b, d);
    cd.left = BreakTie(cd, c, d);
  }
  // Faces wound outwards, (b, c, d), (a, d, c), (a, b, d), (a, c, b): the ray leaves through the
  // one whose three edges all have it on their left, and enters where all have it on their right.
  bool out_a = bc.left && cd.left && !bd.left, in_a = !bc.left && !cd.left && bd.left;
  bool out_b = !cd.left && !ac.left && ad.left, in_b = cd.left && ac.left && !ad.left;
  bool out_c = ab.left && bd.left && !ad.left, in_c = !ab.left && !bd.left && ad.left;
  bool out_d = ac.left && !bc.left && !ab.left, in_d = !ac.left && bc.left && ab.left;
  cut.hit = (in_a || in_b || in_c || in_d) && (out_a || out_b || out_c || out_d);
  cut.face0 = bvec4(in_a, in_b, in_c, in_d);
  cut.face1 = bvec4(out_a, out_b, out_c, out_d);
  cut.at_camera = false;
  cut.z0 = cut.z1 = 0.0;
  cut.w0 = cut.w1 = vec4(0.0);
  TETREC_RARELY(cut.hit) {
    vec4 face_a = vec4(0.0, cd.e, bd.e, bc.e), face_b = vec4(cd.e, 0.0, ad.e, ac.e);
    vec4 face_c = vec4(bd.e, ad.e, 0.0, ab.e), face_d = vec4(bc.e, ac.e, ab.e, 0.0);
    cut.w0 = FaceWeights(in_a ? face_a : in_b ? face_b : in_c ? face_c : face_d, vec4(cut.face0));
    cut.w1 = FaceWeights(out_a ? face_a : out_b ? face_b : out_c ? face_c : face_d, vec4(cut.face1));
    vec4 z = vec4(a.z, b.z, c.z, d.z);
    cut.z0 = dot(cut.w0, z);
    cut.z1 = max(cut.z0, dot(cut.w1, z));
    // The part behind the camera is cut off.
    float camera = -push.start;
    if (cut.z0 < camera) {
      cut.hit = cut.z1 > camera;
      float share = cut.hit ? (camera - cut.z0) / (cut.z1 - cut.z0) : 0.0;
      cut.w0 = mix(cut.w0, cut.w1, share);
      cut.z0 = camera;
      cut.at_camera = true;
    }
  }
  return cut;
}
