// Where density and colour live: on the vertices, linear in each tet, or one of each a tet, constant
// in it (the article's appendix). Rows of the `vertices` buffer: two a vertex, position | density and
// colour | 0; per-cell storage appends one a tet, colour | density, and leaves those of vertices 0.

layout(constant_id = kConstantStorage) const int kStorage = kStorageVertex;
const bool kCells = kStorage == kStorageCell;

// The number of functions by which colours depend on the view (shared/harmonics.glsl.h); 0: they do
// not.
layout(constant_id = kConstantHarmonics) const int kHarmonics = 0;

// Components of a row of parameters or gradients: colour, density.
const int kRowComponents = 4;

// Where attribute row `r`, of a vertex or of a tet, keeps its density (.w) and its colour (.rgb);
// `first_cell` is the row of tet 0.
uint DensityRow(uint r, uint first_cell) { return kCells ? first_cell + r : 2u * r; }
uint ColorRow(uint r, uint first_cell) { return kCells ? first_cell + r : 2u * r + 1u; }
