// Structs, bindings and sizes that the kernels and the host share. Buffers are std430; every struct
// here is made of 16-byte rows so that C++ lays it out the same way.
#ifndef TETREC_GPU_TYPES_GLSL_H_
#define TETREC_GPU_TYPES_GLSL_H_

#ifdef __cplusplus
#include <glm/glm.hpp>

#include <cstddef>
#include <cstdint>
namespace tetrec::gpu_types {
using uint = uint32_t;
using vec4 = glm::vec4;
using uvec4 = glm::uvec4;
#endif

// lavapipe packs lanes along x only: a local size that is not a multiple of 8 is 300 times
// slower.
#define kWorkgroupSize 64
// Rays come in blocks of 4 x 2 neighbours, one 8-wide subgroup on lavapipe.
#define kBlockWidth 4
#define kBlockHeight 2
#define kBlockRays 8

#define kViewRows 5
// A camera: rows of world_from_cam, with the pinhole parameters of the ray grid as fourth
// components.
struct GpuView {
  vec4 right_in_world_fx;    // camera x axis | fx [px]
  vec4 down_in_world_fy;     // camera y axis | fy [px]
  vec4 forward_in_world_cx;  // camera z axis | cx [px]
  vec4 center_in_world_cy;   // camera centre | cy [px]
  // width, height [rays], first pixel of the target image, tet that contains the centre or kNoTet
  uvec4 size_pixel_tet;
};

// A 4 x 2 block of rays of one view; x, y of its first ray in the view's grid; the view's place
// among those of its batch.
struct GpuBlock {
  uint view, x, y, slot;
};

// Specialization constants beside those of integral.glsl.h: whether vertices or tets have density
// and colour, and by how many harmonics colours depend on the view.
#define kConstantStorage 3
#define kStorageVertex 0
#define kStorageCell 1
#define kConstantHarmonics 4
// The activation of density: kActivationExp, kActivationSigned or kActivationSoftplus of
// adam.glsl.h (shaders/density.glsl).
#define kConstantDensityActivation 5
// For the optimiser: from kConstantAttributes on each attribute behind colour and density as
// components | activation << 8 | rate class << 16.
#define kConstantAttributes 6
#define kMostOtherAttributes 6
// 0: backward passes leave out the absolute sums of gradients by position (gradients.glsl).
#define kConstantAbsoluteSums 12
// As RateClass of field/layout.h.
#define kRateColor 0
#define kRateDensity 1
#define kRateHarmonics 2
// Components that every row starts with: colour, then the logarithm of density (in gradients:
// density itself).
#define kColorComponent 0
#define kDensityComponent 3

// What every kernel that follows rays needs, however it finds their tets.
struct RayPush {
  uint ray_count;  // of the batch
  uint jitter_seed;
  float jitter_px;   // rays are moved inside their pixel by up to half of this
  float stop_depth;  // rays stop at this optical depth (-log of transmittance)
  // For fixed-point sums: quanta per unit of gradient, and the largest addend.
  float color_quanta, density_quanta, position_quanta, largest_quanta;
  uint first_cell;  // row of tet 0 among `vertices` if cells have the attributes
};

struct MarchPush {
  RayPush rays;
  uint hull_faces;
  uint hull_planes;  // of a convex boundary without a tree
  uint tree_leaves;  // of the tree of boxes over the faces; 0 if there is none
  vec4 mesh_ball;    // centre, radius: contains the mesh
  vec4 background;   // for sums of edges: rgb [display sRGB] behind the field
  uint max_steps;    // a ray that needs more is counted as lost
  uint score;        // for scores: kScore...
  uint row_count;    // of a slot of view-dependent colours
};

// One pass over a tile of a batch with per-pixel lists. All rays are jittered alike.
struct PpllPush {
  RayPush rays;
  uint block_columns;
  uint view;  // the view of all blocks
  uint face_count;
  vec4 mesh_ball;       // centre, radius: contains the mesh
  uint appends;         // not 0: faces become nodes and are counted; 0: they go into lists
  uint tile_x, tile_y;  // [px] from the batch's first pixel
  uint tile_width;      // [px]
  uint tile_pixels;
  uint shortest, longest;  // lengths of the lists that the sort takes
  uint most_appended;      // nodes that there is room for, or that exist
  uint first_chunk;        // the first chunk of the draw, among the visible ones
};

// Faces come in runs, each of which is drawn or left out as a whole.
#define kFacesPerChunk 16

struct LossPush {
  uint ray_count;
  uint loss;              // kLossL2, ...
  float gradient_scale;   // 1 / (3 x rays)
  uint writes_residuals;  // not 0: gradients are dL/dshown, for scores, which are of what is shown
  vec4 background;        // rgb [display sRGB] behind field and target
  uint samples;           // samples x samples rays per pixel, 1 or 2
  float alpha_weight;     // of opacity; that of a channel is 1
};

// D-SSIM of a batch of tiles of equal shape.
struct DssimPush {
  uint ray_count;
  uint tile_columns, tile_rows;  // blocks per row, rows of blocks
  float gradient_scale;          // dL/dSSIM of one window and channel
  vec4 background;               // as in LossPush
};

struct AdamPush {
  vec4 rates;   // by rate class, after bias correction of the first moment
  vec4 quanta;  // by rate class: one quantum of fixed-point gradients
  uint row_count;
  float beta1, beta2, epsilon;
  float second_moment_correction;        // 1 / (1 - beta2^t)
  float least_log, largest_log;          // bounds of exponential attributes' parameters
  float least_density, largest_density;  // bounds of density's parameter
  float density_scale;                   // of kActivationSigned and kActivationSoftplus
  float density_decay;                   // of the density parameter of a seen row, per step
  float harmonics_decay;                 // share by which coefficients of a seen row decay
  uint first_cell;                       // as in RayPush
  uint stride, moment_stride;            // of rows of attributes behind colour and density
};

// View-dependent colours of the views of a batch.
struct ViewColorPush {
  uint row_count;
  uint first_cell;  // as in RayPush
  uint slots;
  uint other_stride;  // of rows of attributes behind colour and density
};

#define kSeenRowsGroupsAcross 16  // workgroups in a row of them
struct SeenRowsPush {
  uint row_count;
  uint slots;
};

// The same with the step of their coefficients.
struct ViewColorStepPush {
  uint row_count;
  uint first_cell;
  uint slots;
  uint other_stride;
  uint moment_stride;
  float rate, beta2, epsilon;
  float quantum;  // of fixed-point gradients
  float decay;    // share by which the coefficients of a seen row decay in a step
};

// Lengths of the runs of values that one thread counts, adds or moves in prefix sums and sorts.
#define kScanRun 64
#define kSortRun 256
#define kSortDigits 256  // 8 bits per pass

struct ScanPush {
  uint count;     // of values
  uint has_sums;  // scan_apply: 1: runs start at the sums of those before them; 0: at 0
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
#define kItemRun 16  // list items per thread

// A rectangle of one view and a stretch of its tets, sorted front to back.
struct ProjectionPush {
  RayPush rays;  // of the rectangle
  uint view;
  uint first_x, first_y;   // [px]
  vec4 eye_high, eye_low;  // camera centre in the frame of the tets' spheres, as two floats each
  uint block_columns, block_rows;  // of the rectangle
  uint first, count;               // tets, items, or items of each tile's list
  uint is_first, is_last;          // this is the first, or the last, walk of the rays
  float start;         // rays are cut at their camera, but measured from this distance on
  uint offsets_first;  // tet with which the items' offsets start
  float rounding;      // bound on the rounding of distances along a ray
};

struct SpreadPush {
  uint row_count;
  uint first_cell;      // as in RayPush
  float density_scale;  // as in AdamPush
};

// The error of a ray in the scores of its tets (ScoreKind): sums over the channels.
#define kScoreSquaredResidual 0
#define kScoreAbsoluteResidual 1

// Sums of a tet (TetScores): error, then light.
#define kScoresPerTet 2
// Fixed-point tet scores: a ray adds its error times at most 1, and no more than kLargestScore;
// kMostScoredRays of them stay below 2^62 quanta.
#define kScoreQuanta 4294967296.0
#define kLargestScore 64.0
#define kMostScoredRays 16777216
// Smaller shares of a ray's opacity are not added: additions are what scoring costs, and such
// shares decide no split.
#define kLeastScoredShare 1e-3
// The same for light: what a picture of 8 bits hardly shows is not counted.
#define kLeastVisibleShare 1e-2

// Sums of an edge (EdgeSums): slopes by colour and density, then curvatures by both.
#define kEdgeSums 6

// What the backward pass of projected tets keeps per ray between stretches (held_vertices.glsl),
// without and with positions.
#define kRayStateBytes 64
#define kRayStateBytesWithPositions 128

// Specialization constant of march kernels: not 0 if the boundary may have any shape.
#define kConstantAnyBoundary 2

// Counters of the march kernels.
#define kCounterLostRays 0
#define kCounterSteps 1
#define kCounterHitRays 2
#define kCounterClamped 3  // addends of fixed-point sums
#define kCounterCount 4

// Bindings.
#define kBindTets 0      // texels uvec4: vertex ids, neighbours
#define kBindVertices 1  // texels vec4: per vertex position | density, colour | 0 (storage.glsl)
// texels: per boundary face plane (n, w) and ids (a, b, c, tet) as bits; then per node of a tree of
// boxes, if there is one, (min, first) and (max, second), node 0 unused (mesh/boundary.h)
#define kBindHull 2
#define kBindViews 3
#define kBindBlocks 4
#define kBindRayColors 5     // vec4 per ray: colour before the background | optical depth
#define kBindRayEntries 6    // uvec2 per ray, private to the integrator
#define kBindRayGradients 7  // vec4 per ray: dL/dcolour | dL/dtransmittance
#define kBindVertexGradients 8
#define kBindCounters 9
#define kBindTargets 10  // texels uvec4: four RGBA8 pixels of the premultiplied target images
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
#define kBindRectangles 23  // uvec2 per tet: first and last tile (column, row) of its projection
#define kBindVisible 24     // uint per tet: number of visible tets before it
#define kBindSpheres \
  25  // texels vec4, two per tet: centre | power of the origin, high parts, low parts
#define kBindHighKeys 26           // uint a tet
#define kBindOffsets 27            // uint per visible tet: items before its own
#define kBindTileRanges 28         // uvec2 per tile: its stretch of the items
#define kBindRayStates 29          // kRayStateBytes per ray: its walk over projected tets
#define kBindPositionGradients 30  // vec4 per vertex: dL/dposition | absolute sum
#define kBindFaces 31              // uint per face: tet << 3 | number of the face in it << 1
#define kBindLists 32              // uvec2 per ray: first fragment, number of fragments
#define kBindListFills 33          // uint per ray: fragments found so far
#define kBindFragments 34  // uvec2: distance along the ray as bits, face | 1 if it enters the tet
#define kBindPictures 35   // vec2 per channel and ray: rendered value, target
#define kBindWindowRows \
  36  // floats per channel and ray, 5 planes: sums of SSIM's windows along rows
#define kBindWindowTerms 37   // floats per channel and ray, 3 planes: dSSIM / d(means of a window)
#define kBindPartialSsims 38  // float per workgroup
#define kBindFaceChunks 39    // uint per chunk of faces that a tile may see
#define kBindAppended 40      // uvec4: fragment, ray, place in the ray's list
// vec4 per row: share of the learning rates, parameter of density from which on it does not decay,
// least parameter of density, 0
#define kBindRowRates 41
#define kBindExposures 42     // texels vec4, two per view: gain, offset
#define kBindExposureSums 43  // vec4, four per block (exposure_sums.comp)
#define kBindRayReaches 44    // float per ray: distance at which it reaches the stop depth, or 0
// Attributes behind colour and density: gradients by row, and whether a row has any (uint).
#define kBindOtherGradients 45
#define kBindHasGradients 46
#define kBindHarmonics 47      // texels: coefficients of view-dependent colour by row
#define kBindCenters 48        // texels vec4, one per slot: camera centre
#define kBindViewColors 49     // vec4, rows [slot][row]: view-dependent colours, to be written
#define kBindColors 50         // texels vec4: the same, or `vertices`
#define kBindSlotGradients 51  // rows [slot][row] as those of kBindVertexGradients
// texels vec4: rows of kBindVertexGradients, kBindParameters and (first, second) kBindMoments
#define kBindGradientTexels 52
#define kBindParameterTexels 53
#define kBindMomentTexels 54
// texels vec4: rows of kBindSlotGradients and kBindOtherGradients
#define kBindSlotGradientTexels 55
#define kBindOtherGradientTexels 56
#define kBindTetEdges 57  // uint, six per tet: ids of its edges
#define kBindEdgeSums 58  // kEdgeSums per edge
// uint: the rows to which a batch gave gradients, behind how many there are and the workgroups for
// them (CommandRecorder::DispatchCounted)
#define kBindSeenRows 59
#define kSeenRowsGroups 0  // three
#define kSeenRowsCount 3
#define kSeenRowsHeader 4
#define kBindRowRateTexels 60  // texels vec4: those of kBindRowRates

#ifdef __cplusplus
static_assert(sizeof(GpuView) == 16 * kViewRows && sizeof(GpuBlock) == 16);
// Every device takes 128 bytes of push constants; std430 aligns vec4 to 16.
static_assert(sizeof(MarchPush) <= 128 && sizeof(LossPush) <= 128 && sizeof(AdamPush) <= 128);
static_assert(sizeof(DssimPush) == 32 && sizeof(ProjectionPush) <= 128 && sizeof(PpllPush) <= 128);
static_assert(offsetof(MarchPush, background) % 16 == 0);
static_assert(offsetof(MarchPush, mesh_ball) % 16 == 0 && offsetof(PpllPush, mesh_ball) % 16 == 0);
static_assert(offsetof(ProjectionPush, eye_high) % 16 == 0);
}  // namespace tetrec::gpu_types
#endif

#endif  // TETREC_GPU_TYPES_GLSL_H_
