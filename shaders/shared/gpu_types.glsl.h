// Structs, bindings and sizes that the kernels and the host share. Buffers are std430; every struct
// here is made of 16-byte rows so that C++ lays it out the same way.
#ifndef TETREC_GPU_TYPES_GLSL_H_
#define TETREC_GPU_TYPES_GLSL_H_

#ifdef __cplusplus
#include <glm/glm.hpp>

#include <cstdint>
namespace tetrec::gpu_types {
using uint = uint32_t;
using vec4 = glm::vec4;
using uvec4 = glm::uvec4;
#endif

// lavapipe packs lanes along x only: a local size that is no multiple of 8 is 300 times slower.
#define kWorkgroupSize 64
// Rays come in blocks of 4 x 2 neighbouring pixels, one 8-wide subgroup on lavapipe.
#define kBlockWidth 4
#define kBlockHeight 2
#define kBlockRays 8

#define kViewRows 5
// A camera; rows of world_from_cam with the pinhole parameters of the ray grid beside them.
struct GpuView {
  vec4 right_in_world_fx;    // camera x axis | fx [px]
  vec4 down_in_world_fy;     // camera y axis | fy [px]
  vec4 forward_in_world_cx;  // camera z axis | cx [px]
  vec4 center_in_world_cy;   // camera centre | cy [px]
  // width, height [px], first pixel of the target picture, tet that holds the centre or kNoTet
  uvec4 size_pixel_tet;
};

// A 4 x 2 block of rays of one view; x, y [px] of its first pixel.
struct GpuBlock {
  uint view, x, y, padding;
};

// Moments of Adam of one vertex: rgb, log density.
struct Moments {
  vec4 first, second;
};

// Specialization constant beside those of integral.glsl.h: whether vertices or tets have density
// and colour.
#define kConstantStorage 3
#define kStorageVertex 0
#define kStorageCell 1

struct MarchPush {
  vec4 mesh_ball;  // centre, radius: holds the mesh
  uint ray_count;
  uint hull_faces;
  uint hull_planes;  // of a convex boundary without tree
  uint tree_leaves;  // of the tree of boxes over the faces, where there is one
  uint max_steps;    // a ray that needs more is counted as lost
  uint jitter_seed;
  float jitter_px;   // rays are moved inside their pixel by up to half of this
  float stop_depth;  // rays stop at this optical depth (-log of transmittance)
  // Of fixed-point sums: quanta a unit of gradient, and the largest addend.
  float color_quanta, density_quanta, position_quanta, largest_quanta;
  uint first_cell;  // row of tet 0 among `vertices`, where cells have the attributes
};

// One pass over a tile of a batch with per-pixel lists.
struct PpllPush {
  vec4 mesh_ball;  // centre, radius: holds the mesh
  uint ray_count;  // of the batch
  uint block_columns;
  uint jitter_seed;
  float jitter_px;   // all rays are moved alike, by up to half of this
  float stop_depth;  // rays stop at this optical depth (-log of transmittance)
  uint face_count;
  uint appends;         // faces become nodes and are counted, else they go into lists
  uint tile_x, tile_y;  // [px] from the batch's first pixel
  uint tile_width;      // [px]
  uint tile_pixels;
  uint shortest, longest;  // lists that the sort takes
  // Of fixed-point sums, as in MarchPush.
  float color_quanta, density_quanta, position_quanta, largest_quanta;
  uint first_cell;     // as in MarchPush
  uint view;           // that all blocks name
  uint most_appended;  // nodes that there is room for, or are
  uint first_chunk;    // of the draw's, among the visible ones
  uint padding0, padding1, padding2;
};

// Faces come in runs, which are drawn or left out as a whole.
#define kFacesPerChunk 16

struct LossPush {
  uint ray_count;
  uint loss;             // kLossL2 or kLossL1
  float gradient_scale;  // 1 / (3 x rays)
  uint padding;
  vec4 background;  // rgb [display sRGB], stands behind field and target
};

// D-SSIM of a batch of tiles, all alike.
struct DssimPush {
  uint ray_count;
  uint tile_columns, tile_rows;  // blocks a row, rows of blocks
  float gradient_scale;          // dL/dSSIM of one window and channel
  vec4 background;               // as in LossPush
};

struct AdamPush {
  uint row_count;
  float beta1, beta2, epsilon;
  float color_rate, density_rate;  // after bias correction of the first moment
  float second_moment_correction;  // 1 / (1 - beta2^t)
  float max_log_density;
  float density_decay;                   // of the log density of a seen vertex, a step
  float color_quantum, density_quantum;  // of fixed-point gradients
  uint first_cell;                       // as in MarchPush
};

// Runs of values that one thread counts, adds or moves in prefix sums and sorts.
#define kScanRun 64
#define kSortRun 256
#define kSortDigits 256  // 8 bits a pass

struct ScanPush {
  uint count;     // of values
  uint has_sums;  // apply: runs begin at the sums of those before; else at 0
};

struct SortPush {
  uint count;
  uint shift;  // of the digit
  uint runs;
};

// Tiles of projected tets: 2 x 2 blocks, 8 x 4 pixels.
#define kTileColumns 2
#define kTileRows 2
#define kTileRays (kTileColumns * kTileRows * kBlockRays)
#define kItemRun 16  // list items of one thread

// A rectangle of one view and a stretch of its tets, sorted front to back.
struct ProjectionPush {
  uint ray_count;  // of the rectangle
  uint view;
  uint first_x, first_y;           // [px]
  uint block_columns, block_rows;  // of the rectangle
  uint first, count;               // tets, items, or items of each tile's list
  uint is_first, is_last;          // time that the rays walk
  uint jitter_seed;
  float jitter_px;
  float stop_depth;
  float start;         // rays are cut at their camera, but measured from this distance on
  uint offsets_first;  // tet that the items' offsets begin with
  // Of fixed-point sums, as in MarchPush.
  float color_quanta, density_quanta, position_quanta, largest_quanta;
  float rounding;          // of distances along a ray, at most
  vec4 eye_high, eye_low;  // camera centre in the frame of the tets' spheres, as two floats each
  uint first_cell;         // as in MarchPush
};

struct SpreadPush {
  uint row_count;
  uint first_cell;  // as in MarchPush
};

// Of fixed-point tet scores: a ray adds its squared residual times at most 1, and no more than
// kLargestScore; kMostScoredRays of them stay below 2^62 quanta.
#define kScoreQuanta 4294967296.0
#define kLargestScore 64.0
#define kMostScoredRays 16777216
// Of a ray's opacity; additions are what scoring costs, and smaller shares decide no split.
#define kLeastScoredShare 1e-3

// What the backward pass of projected tets keeps of a ray between stretches (held_vertices.glsl),
// without and with positions.
#define kRayStateBytes 64
#define kRayStateBytesWithPositions 128

// Of march kernels, beside those of the integral (integral.glsl.h): not 0 where the boundary may
// have any shape.
#define kConstantAnyBoundary 2

// Counters of the march kernels.
#define kCounterLostRays 0
#define kCounterSteps 1
#define kCounterHitRays 2
#define kCounterClamped 3  // addends of fixed-point sums
#define kCounterCount 4

// Bindings.
#define kBindTets 0      // texels uvec4: vertex ids, neighbours
#define kBindVertices 1  // texels vec4: position | density, colour | 0 a vertex (storage.glsl)
// texels: per boundary face plane (n, w) and ids (a, b, c, tet) as bits; where the boundary has a
// tree of boxes per node (min, first) and (max, second), node 0 none (mesh/boundary.h)
#define kBindHull 2
#define kBindViews 3
#define kBindBlocks 4
#define kBindRayColors 5     // vec4 a ray: colour before the background | optical depth
#define kBindRayEntries 6    // uvec2 a ray, the integrator's own
#define kBindRayGradients 7  // vec4 a ray: dL/dcolour | dL/dtransmittance
#define kBindVertexGradients 8
#define kBindCounters 9
#define kBindTargets 10  // texels rgba8: premultiplied target pictures
#define kBindTetScores 11
#define kBindPartialLosses 12
#define kBindParameters 13
#define kBindMoments 14
#define kBindSums 15    // prefix sums: totals of runs
#define kBindValues 16  // prefix sums: values
#define kBindKeys 17    // sort
#define kBindItems 18
#define kBindSortedKeys 19
#define kBindSortedItems 20
#define kBindDigitCounts 21
#define kBindTable 22       // gather: values by item
#define kBindRectangles 23  // uvec2 a tet: tiles of its projection, first and last column, row
#define kBindVisible 24     // uint a tet: places before it among the visible
#define kBindSpheres \
  25  // texels vec4, two a tet: centre | power of the origin, high parts, low parts
#define kBindHighKeys 26           // uint a tet
#define kBindOffsets 27            // uint a visible tet: items before its own
#define kBindTileRanges 28         // uvec2 a tile: its stretch of the items
#define kBindRayStates 29          // kRayStateBytes a ray: the walk of projected tets
#define kBindPositionGradients 30  // vec4 a vertex: dL/dposition | absolute sum
#define kBindFaces 31              // uint a face: tet << 3 | number of the face in it << 1
#define kBindLists 32              // uvec2 a ray: first fragment, fragments
#define kBindListFills 33          // uint a ray: fragments found so far
#define kBindFragments \
  34                      // uvec2: distance along the ray as bits, face | 1 where it enters the tet
#define kBindPictures 35  // vec2 a channel and ray: what it shows, its target
#define kBindWindowRows 36  // floats a channel and ray, 5 planes: sums of SSIM's windows along rows
#define kBindWindowTerms 37   // floats a channel and ray, 3 planes: dSSIM / d(means of a window)
#define kBindPartialSsims 38  // float a workgroup
#define kBindFaceChunks 39    // uint a chunk of faces that a tile may see
#define kBindAppended 40      // uvec4: fragment, ray, place in the ray's list

#ifdef __cplusplus
static_assert(sizeof(GpuView) == 16 * kViewRows && sizeof(GpuBlock) == 16);
static_assert(sizeof(MarchPush) <= 128 && sizeof(LossPush) <= 128 && sizeof(AdamPush) <= 128);
static_assert(sizeof(DssimPush) == 32);
static_assert(sizeof(ProjectionPush) <= 128 && sizeof(PpllPush) == 112);
}  // namespace tetrec::gpu_types
#endif

#endif  // TETREC_GPU_TYPES_GLSL_H_
