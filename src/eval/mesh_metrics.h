// How close a reconstructed surface is to the true one.
#pragma once

#include "geometry/bounds3.h"
#include "geometry/rigid3.h"
#include "mesh/triangle_mesh.h"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace tetrec {

struct SurfaceSamples {
  std::vector<glm::dvec3> positions;
  std::vector<uint32_t> triangles;  // the triangle each sample lies on
};

// `count` points spread evenly by area. The same seed gives the same points. Throws DataError where
// the mesh has no area.
SurfaceSamples SampleSurface(const TriangleMesh& mesh, size_t count, uint64_t seed);

// Distance from each point to the surface of `mesh`. Exact for the triangles that carry the point's
// 16 nearest of `samples` area samples and all triangle centres; what another triangle might
// undercut is far below the spacing of these samples. Deterministic. Throws DataError for a mesh
// without area.
std::vector<double> DistancesToSurface(std::span<const glm::dvec3> points, const TriangleMesh& mesh,
                                       size_t samples, uint64_t seed);

struct SurfaceScoreOptions {
  double threshold = 0.01;  // of the subject's diagonal: what counts as found
  size_t samples = 200000;  // points on each surface
  uint64_t seed = 1;
  // Only what lies inside is judged, of both surfaces [units of the truth]. Default: the truth's
  // bounding box, grown by 5 % of its size, so that a table far below does not count.
  std::optional<Bounds3> bounds;
};

// Distances in the truth's units. Nothing of the reconstruction inside the box: precision, recall
// and F-score are 0 and the distances empty.
struct SurfaceScores {
  Bounds3 crop;
  double diagonal = 0;  // of the judged part of the truth's bounding box
  double threshold = 0;
  size_t reconstruction_samples = 0, truth_samples = 0;  // inside the box
  std::optional<double> accuracy;                        // mean distance reconstruction -> truth
  std::optional<double> completeness;                    // mean distance truth -> reconstruction
  std::optional<double> chamfer;                         // mean of the two
  double precision = 0, recall = 0;  // shares of the samples nearer than the threshold
  double f_score = 0;                // harmonic mean of precision and recall
};

// Both meshes in the truth's frame. Only samples are cropped, never the surface that they are
// measured against, so the box's walls cost nothing. Throws DataError where the truth has no area
// in the box.
SurfaceScores CompareSurfaces(const TriangleMesh& reconstruction, const TriangleMesh& truth,
                              const SurfaceScoreOptions& options);

}  // namespace tetrec
