// Colours for kernels that integrate along rays, of vertices and of cells. The including kernel
// declares `vertices`.

#include "storage.glsl"

// If colours depend on the view, rows [slot][row] of what the batch's views see (view_colors.comp);
// otherwise `vertices`.
layout(binding = kBindColors) uniform textureBuffer colors;

// Row 0 of the ray's slot in `colors`. Batches of one view have slot 0.
uint g_first_color = 0u;

// Colour of a vertex; 0 if vertices have none.
vec3 FetchVertexColor(uint id) {
  vec3 color = vec3(0.0);
  if (!kCells) color = texelFetch(colors, int(kHarmonics > 0 ? g_first_color + id : 2u * id + 1u)).rgb;
  return color;
}

// Colour | density of a tet.
vec4 FetchCell(uint tet) {
  vec4 cell = texelFetch(vertices, int(push.rays.first_cell + tet));
  if (kHarmonics > 0) cell.rgb = texelFetch(colors, int(g_first_color + tet)).rgb;
  return cell;
}

// With per-cell storage, replaces the values at both ends of a segment in `tet` by those of the tet.
#define UseCell(tet, density0, density1, payload0, payload1) \
  if (kCells) {                                              \
    vec4 cell = FetchCell(tet);                              \
    density0 = density1 = cell.a;                            \
    payload0 = payload1 = MakePayload(cell.rgb);             \
  }
