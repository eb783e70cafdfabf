// Gradients of the loss with respect to the values at the ends of a ray's segment, and their sums
// at the vertices.
//
// With g = dL/dcolour and h = dL/dtransmittance of a ray, its part of the loss is
// S = sum_i T_i (w0 g.c0 + w1 g.c1)_i + h T_end, all scalars; a "payload" is g . colour. A change
// of density in segment i scales everything behind it by d(-tau): -1/2 each for s0 and s1.
//
// TETREC_POSITIONS adds gradients with respect to the vertices' positions. A ray meets the face
// with corners p_j and weights w_j at z, where density and colour are q. Across the ray, z and q
// are linear functions on the face; moving p_j by m moves them along with weight w_j:
//   dq/dp_j = -w_j (dq/dx, dq/dy, 0), dz/dp_j = -w_j (dz/dx, dz/dy, -1),
// in the world frame w_j [((g.d)/(n.d)) n - g] and w_j n/(n.d), where g is the slope of q in the
// face. A ray that starts at a camera keeps starting there: dz = 0, dq/dp_j = -w_j grad q.
//
// The including kernel declares `push`, `counters` and g_color, the ray's dL/dcolour.

// Rows of the field, or, if colours depend on the view, of each slot (view_color_sums.glsl).
layout(std430, binding = kBindVertexGradients) buffer VertexGradients { Sum vertex_gradients[]; };

// Gradients with respect to (z, density, payload) at the ends of a segment. The one for the payload
// is the weight of the end's colour: dL/dcolour is g times it.
struct EndGradients {
  vec3 entry, exit;
};

// `behind` is the part of the loss behind the segment, t the transmittance before it.
EndGradients GradientsOfEnds(SegmentAdjoint adjoint, float t, float behind, float size,
                             float density0, float density1, float payload0, float payload1) {
  float by_s0 = t * (adjoint.dw0_ds0 * payload0 + adjoint.dw1_ds0 * payload1) - 0.5 * behind;
  float by_s1 = t * (adjoint.dw0_ds1 * payload0 + adjoint.dw1_ds1 * payload1) - 0.5 * behind;
  float by_size = density0 * by_s0 + density1 * by_s1;
  return EndGradients(vec3(-by_size, size * by_s0, t * adjoint.w0),
                      vec3(by_size, size * by_s1, t * adjoint.w1));
}

// Gradients at the ends of a segment from those at the ends of the part that a cut leaves.
EndGradients OfWhole(SegmentCut cut, EndGradients part) {
  return EndGradients((1.0 - cut.begin) * part.entry + (1.0 - cut.end) * part.exit,
                      cut.begin * part.entry + cut.end * part.exit);
}

// x: dL/ddensity, y: the sum of colour weights.
void AddToVertex(uint id, vec2 gradient) {
  if (gradient.x != 0.0 || gradient.y != 0.0) {
    uint row = uint(kRowComponents) * ((kHarmonics > 0 ? g_first_color : 0u) + id);
    uint color = row + kColorComponent;
    AddTo(vertex_gradients[color], g_color.r * gradient.y, push.rays.color_quanta);
    AddTo(vertex_gradients[color + 1u], g_color.g * gradient.y, push.rays.color_quanta);
    AddTo(vertex_gradients[color + 2u], g_color.b * gradient.y, push.rays.color_quanta);
    AddTo(vertex_gradients[row + kDensityComponent], gradient.x, push.rays.density_quanta);
  }
}

// Adds all gradients of a segment to its tet, if cells have the attributes.
void AddToCell(uint tet, EndGradients ends) { AddToVertex(tet, ends.entry.yz + ends.exit.yz); }

#ifdef TETREC_POSITIONS
layout(std430, binding = kBindPositionGradients) buffer PositionGradients {
  Sum position_gradients[];
};

layout(constant_id = kConstantAbsoluteSums) const int kAbsoluteSums = 1;

mat3 world_from_ray;

// Adds the position gradient of one passage through the tets around a vertex, given in the ray's
// frame.
void AddMoveToVertex(uint id, vec3 move) {
  if (move != vec3(0.0)) {
    vec3 in_world = world_from_ray * move;
    AddTo(position_gradients[4u * id], in_world.x, push.rays.position_quanta);
    AddTo(position_gradients[4u * id + 1u], in_world.y, push.rays.position_quanta);
    AddTo(position_gradients[4u * id + 2u], in_world.z, push.rays.position_quanta);
    if (kAbsoluteSums != 0) {
      AddTo(position_gradients[4u * id + 3u], length(move.xy), push.rays.position_quanta);
    }
  }
}

// -dz/dp, -ddensity/dp and -dpayload/dp at the end of a segment for a corner of weight 1, in the
// ray's frame.
struct Slopes {
  vec3 z, density, payload;
};

// The corners of a face in the ray's frame, with their values.
struct FaceCorners {
  vec3 a, b, c;
  vec3 density, payload;
};

// Slopes at an end on a face with the edge functions e of (b, c), (c, a), (a, b). Those across the
// ray are 0 if the face is seen edge-on: below this share of its squared size, its area across the
// ray is rounding. The same corners in the same order always give the same bits.
Slopes SlopesOnFace(FaceCorners face, vec3 e) {
  vec2 a = face.a.xy, b = face.b.xy, c = face.c.xy;
  precise float size = dot(a, a) + dot(b, b) + dot(c, c);
  precise float area = e.x + e.y + e.z;
  precise float scale = abs(area) > 1e-6 * size ? 1.0 / area : 0.0;
  // Derivatives of the weights of a, b, c.
  precise vec3 by_x = scale * vec3(b.y - c.y, c.y - a.y, a.y - b.y);
  precise vec3 by_y = scale * vec3(c.x - b.x, a.x - c.x, b.x - a.x);
  vec3 z = vec3(face.a.z, face.b.z, face.c.z);
  precise Slopes slopes;
  slopes.z = vec3(dot(by_x, z), dot(by_y, z), -1.0);
  slopes.density = vec3(dot(by_x, face.density), dot(by_y, face.density), 0.0);
  slopes.payload = vec3(dot(by_x, face.payload), dot(by_y, face.payload), 0.0);
  return slopes;
}

// Slopes at a camera inside the tet (p, a, b, c), whose density and payload come in that order; 0
// if the tet is flat up to rounding.
Slopes SlopesInTet(vec3 p, vec3 a, vec3 b, vec3 c, vec4 density, vec4 payload) {
  a -= p, b -= p, c -= p;
  float volume = dot(a, cross(b, c));
  bool is_flat = abs(volume) <= 1e-6 * length(a) * length(b) * length(c);
  float scale = is_flat ? 0.0 : 1.0 / volume;
  mat3 by_corner = scale * mat3(cross(b, c), cross(c, a), cross(a, b));
  Slopes slopes;
  slopes.z = vec3(0.0);
  slopes.density = by_corner * (density.yzw - density.x);
  slopes.payload = by_corner * (payload.yzw - payload.x);
  return slopes;
}

// dL/dposition of a corner of weight 1, from dL/d(z, density, payload) at the end of a segment.
vec3 MoveOf(Slopes slopes, vec3 end) {
  return -(end.x * slopes.z + end.y * slopes.density + end.z * slopes.payload);
}
#endif
