// Moves of a surface's vertices to where its pictures differ less from the photos.
#pragma once

#include "mesh/triangle_mesh.h"
#include "surface/photo_differences.h"
#include "surface/vertex_fans.h"

#include <span>
#include <vector>

namespace tetrec {

// What stays the same about a surface however its vertices move.
struct SurfaceTopology {
  VertexFans fans;
  std::vector<bool> border;  // BorderVertices

  explicit SurfaceTopology(const TriangleMesh& mesh) : fans(mesh), border(BorderVertices(mesh)) {}
};

// Moves all vertices at once, each by half a pixel at most, where the differences pull them. Moves
// vary smoothly over the surface: `stiffness` pulls each to the mean of its neighbours' as the
// curvature of the error pulls it to where the photos want it. Vertices at borders stay. Moves that
// would turn a triangle over are undone, and those that would make the surface cross itself are
// shortened (StepBackFromCrossings).
TriangleMesh MovedTowardsPhotos(const TriangleMesh& mesh, const SurfaceTopology& topology,
                                std::span<const VertexDifferences> differences, float stiffness);

// Mean length of the moves of the vertices that photos see [footprints].
double MeanMove(const TriangleMesh& from, const TriangleMesh& to,
                std::span<const VertexDifferences> differences);

}  // namespace tetrec
