// The vertices of the tet or face that a ray is in, each with the sum of the ray's gradients for
// it. The sum is added to the vertex when the ray leaves it: once per passage through the tets
// around it, so that opposite contributions of neighbouring tets cancel beforehand and absolute
// sums equal those of the march.
#include "gradients.glsl"

// std430; 64 or 128 bytes together with what projection_backward.comp keeps beside it.
struct HeldVertices {
  uvec4 ids;        // all different, except for kNoVertex
  mat4x2 gradient;  // columns as AddToVertex takes them
#ifdef TETREC_POSITIONS
  mat4x3 move;  // columns as AddMoveToVertex takes them
#endif
};

HeldVertices HoldNothing() {
  HeldVertices held;
  held.ids = uvec4(kNoVertex);
  held.gradient = mat4x2(0.0);
#ifdef TETREC_POSITIONS
  held.move = mat4x3(0.0);
#endif
  return held;
}

// Releases the held vertices that are not in `ids`, and holds those that are.
void Hold(inout HeldVertices held, uvec4 ids) {
  bvec4 leaves = bvec4(!any(equal(ids, held.ids.xxxx)), !any(equal(ids, held.ids.yyyy)),
                       !any(equal(ids, held.ids.zzzz)), !any(equal(ids, held.ids.wwww)));
  leaves = bvec4(uvec4(leaves) & uvec4(notEqual(held.ids, uvec4(kNoVertex))));
  bool go = any(leaves);
  while (go) {  // usually once
    bvec4 first = bvec4(leaves.x, leaves.y && !leaves.x, leaves.z && !(leaves.x || leaves.y),
                        leaves.w && !(leaves.x || leaves.y || leaves.z));
    uint id = first.x ? held.ids.x : first.y ? held.ids.y : first.z ? held.ids.z : held.ids.w;
    if (!kCells) AddToVertex(id, held.gradient * vec4(first));
#ifdef TETREC_POSITIONS
    AddMoveToVertex(id, held.move * vec4(first));
#endif
    leaves = bvec4(uvec4(leaves) & uvec4(not(first)));
    go = any(leaves);
  }
  // Column i selects the sum of vertex i, if it was held.
  mat4 stays = mat4(vec4(equal(held.ids, ids.xxxx)), vec4(equal(held.ids, ids.yyyy)),
                    vec4(equal(held.ids, ids.zzzz)), vec4(equal(held.ids, ids.wwww)));
  held.ids = ids;
  held.gradient = held.gradient * stays;
#ifdef TETREC_POSITIONS
  held.move = held.move * stays;
#endif
}

void LetGo(inout HeldVertices held) { Hold(held, uvec4(kNoVertex)); }

// Adds dL/d(z, density, payload) at an end of a segment to the held vertices by their weights there.
void Deposit(inout HeldVertices held, vec4 weights, vec3 end) {
  if (!kCells) held.gradient += outerProduct(end.yz, weights);
}

#ifdef TETREC_POSITIONS
void DepositMove(inout HeldVertices held, vec4 weights, vec3 move) {
  held.move += outerProduct(move, weights);
}
#endif
