// Per-cell storage for kernels that integrate along rays. The including kernel declares `vertices`.

#include "storage.glsl"

// Colour of a vertex; 0 if vertices have none.
vec3 FetchVertexColor(uint id) {
  vec3 color = vec3(0.0);
  if (!kCells) color = texelFetch(vertices, int(2u * id + 1u)).rgb;
  return color;
}

// Colour | density of a tet.
vec4 FetchCell(uint tet) { return texelFetch(vertices, int(push.rays.first_cell + tet)); }

// With per-cell storage, replaces the values at both ends of a segment in `tet` by those of the tet.
#define UseCell(tet, density0, density1, payload0, payload1) \
  if (kCells) {                                              \
    vec4 cell = FetchCell(tet);                              \
    density0 = density1 = cell.a;                            \
    payload0 = payload1 = MakePayload(cell.rgb);             \
  }
