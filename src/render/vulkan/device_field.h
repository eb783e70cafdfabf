// A field on the device: mesh, parameters, gradients, the state of Adam.
#pragma once

#include "field/field_state.h"
#include "gpu/buffer.h"
#include "render/training_renderer.h"
#include "render/vulkan/fixed_point.h"

#include <span>
#include <string>

namespace tetrec {

// What rows have behind colour and density, apart from them so that steps without it pay nothing.
// Rows have `stride` values, a multiple of 4 and as many as there are components or more.
struct OtherAttributes {
  uint32_t components = 0, stride = 0;
  uint32_t attributes = 0;  // moments of a row
  Buffer parameters;        // rows
  Buffer moments;           // rows of one second moment per attribute
  // Sums, absent until asked for: rows of gradients, and uint per row, whether it has any.
  Buffer gradients, has_gradients;

  explicit operator bool() const { return components > 0; }
  bool HasSums() const { return gradients.handle() != VK_NULL_HANDLE; }
};

// 32 bytes per tet, 32 per vertex, and per row of attributes to learn 16 more for each component
// of colour and density (20 in fixed point) and 8 for each component behind them (12); 16 more per
// tet if cells have the attributes; one plane and one triangle per boundary face, and over them the
// planes of a convex boundary of few faces, or a tree of boxes.
struct DeviceField {
  TetMesh mesh;            // the host's copy
  std::string not_convex;  // why the boundary is not convex; empty if it is convex
  glm::vec4 ball{0.0f};    // centre, radius: contains the mesh
  Buffer tets, vertices, hull;
  Buffer parameters, gradients;  // rows of kStandardComponents
  Buffer moments;                // rows: all first moments of a row, then all second ones
  OtherAttributes others;
  Buffer row_rates;           // vec4 per row (kBindRowRates)
  Buffer position_gradients;  // vec4 per vertex: xyz | absolute sum; absent until asked for
  Buffer tet_scores;
  uint32_t vertex_count = 0, tet_count = 0, hull_faces = 0, hull_planes = 0;
  FieldLayout layout;
  uint32_t row_count = 0;    // of parameters, moments, gradients: vertex_count or tet_count
  uint32_t first_cell = 0;   // row of tet 0 in `vertices`, behind those of the vertices
  uint32_t tree_leaves = 0;  // of the tree of boxes; 0 if there is none
  bool fixed_point = false;  // gradients, position_gradients, tet_scores: int64 instead of float
  uint32_t most_tets_at_vertex = 0;
  double diagonal = 0;  // of the mesh's bounds [world units]
};

// The most that a field takes on the device per tet, vertex and boundary face, with position
// gradients and a tree of boxes.
struct DeviceFieldBytes {
  uint64_t of_tet, of_vertex, of_face;
};
DeviceFieldBytes BytesOf(const FieldLayout& layout, bool fixed_point, size_t views_per_batch);

// Gradients and scores start at zero. Density and colour in `vertices` are yet to be spread from
// the parameters (spread.comp).
DeviceField UploadField(const Device& device, TetMesh mesh, const FieldState& state,
                        bool fixed_point);

// Sums of gradients, by value: rows x layout.Components().
std::vector<double> DownloadGradients(const DeviceField& field, const FixedPoint& fixed);
void AddToGradients(DeviceField& field, std::span<const double> values, const FixedPoint& fixed);
void ClearGradients(DeviceField& field);
// The same of position_gradients: rows of four.
std::vector<double> DownloadPositionGradients(const DeviceField& field, const FixedPoint& fixed);
void AddToPositionGradients(DeviceField& field, std::span<const double> values,
                            const FixedPoint& fixed);
// Replaces the parameters: rows x layout.Components().
void UploadParameters(DeviceField& field, std::span<const float> parameters);
void UploadRowRates(DeviceField& field, std::span<const RowRates> rates);  // one per row
// Moves the vertices; density and colour are yet to be spread again.
void UploadPositions(DeviceField& field, std::span<const glm::vec3> positions);
// Tet scores.
TetScores DownloadScores(const DeviceField& field);

// Makes position_gradients, zero, if it is absent.
void AllocatePositionGradients(const Device& device, DeviceField& field);
// The same for the sums of other attributes, if there are any.
void AllocateOtherGradients(const Device& device, DeviceField& field);

// Parameters and moments. The device must not be using them.
FieldState DownloadState(const DeviceField& field);

}  // namespace tetrec
