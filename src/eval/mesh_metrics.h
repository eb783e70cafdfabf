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
  std::vector<uint32_t> triangles;  // the triangle that each sample is on
};

// `count` points spread evenly by area. The same seed gives the same points. Throws DataError if
// the mesh has no area.
SurfaceSamples SampleSurface(const TriangleMesh& mesh, size_t count, uint64_t seed);

struct NearestTriangle {
  double distance = 0;
  uint32_t triangle = 0;
};
// For each point the nearest of a few triangles of `mesh`, and its exact distance: those of the 16
// points nearest to it among `samples` area samples and all triangle centres. Another triangle can
// be nearer only by far less than the spacing of these points. Deterministic. Throws DataError for
// a mesh without area.
std::vector<NearestTriangle> NearestTriangles(std::span<const glm::dvec3> points,
                                              const TriangleMesh& mesh, size_t samples,
                                              uint64_t seed);

struct SurfaceScoreOptions {
  double threshold = 0.01;  // distance that counts as found [share of the subject's diagonal]
  size_t samples = 200000;  // points on each surface
  uint64_t seed = 1;
  // Only the parts of both surfaces inside are scored [units of the truth]. Default: the truth's
  // bounding box, so that a table far below does not count, grown by 5 % of its sides; of sides
  // that are thinner than a cube's of the same diagonal, by 5 % of the cube's.
  std::optional<Bounds3> bounds;
};

// Precision, recall and F-score at one distance.
struct ScoresAtDistance {
  double threshold = 0;              // [units of the truth]
  double precision = 0, recall = 0;  // shares of the samples nearer than the threshold
  double f_score = 0;                // harmonic mean of precision and recall
};

// At which distances surfaces are scored, in shares of the threshold.
inline constexpr double kThresholdShares[] = {0.25, 0.5, 1, 2};

// Distances in the truth's units. If nothing of the reconstruction is inside the box, precision,
// recall and F-score are 0 and there are no distances.
struct SurfaceScores {
  Bounds3 crop;
  double diagonal = 0;  // of the part of the truth's bounding box inside `crop`
  double threshold = 0;
  size_t reconstruction_samples = 0, truth_samples = 0;  // inside the box
  std::optional<double> accuracy;                        // mean distance reconstruction -> truth
  std::optional<double> completeness;                    // mean distance truth -> reconstruction
  std::optional<double> chamfer;                         // mean of the two
  double precision = 0, recall = 0;            // shares of the samples nearer than the threshold
  double f_score = 0;                          // harmonic mean of precision and recall
  std::vector<ScoresAtDistance> at_distances;  // one per share of the threshold
  // Mean angle between the normals of a sample's triangle and of the nearest triangle of the other
  // surface [degrees], 180 where one of them is inside out; mean over both directions, over samples
  // nearer than the threshold. Nothing if there are none.
  std::optional<double> normal_angle_deg;
};

// Both meshes are in the truth's frame. Only samples are cropped, never the surface that distances
// are measured to, so the walls of the box do not distort them. Throws DataError if the truth has
// no area in the box.
SurfaceScores CompareSurfaces(const TriangleMesh& reconstruction, const TriangleMesh& truth,
                              const SurfaceScoreOptions& options);

}  // namespace tetrec
