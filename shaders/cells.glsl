// Per-cell storage for kernels that integrate along rays (after storage.glsl and `vertices`).

#include "storage.glsl"

// Colour of a vertex; 0 where vertices have none.
vec3 FetchVertexColor(uint id) {
  vec3 color = vec3(0.0);
  if (!kCells) color = texelFetch(vertices, int(2u * id + 1u)).rgb;
  return color;
}

// Colour | density of a tet.
vec4 FetchCell(uint tet) { return texelFetch(vertices, int(push.first_cell + tet)); }

// Puts what a segment in `tet` has at both ends in place of what the vertices have there.
#define UseCell(tet, density0, density1, payload0, payload1) \
  if (kCells) {                                              \
    vec4 cell = FetchCell(tet);                              \
    density0 = density1 = cell.a;                            \
    payload0 = payload1 = MakePayload(cell.rgb);             \
  }
