// Search along normals, and displacements that vary smoothly over the surface.
#include "surface/align_with_photos.h"

#include "core/parallel.h"
#include "surface/photo_agreement.h"
#include "surface/sighting.h"
#include "surface/step_back.h"
#include "surface/vertex_fans.h"
#include "surface/vertex_normals.h"

#include <glm/glm.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

namespace tetrec {
namespace {

constexpr int kSteps = 4;            // of the search, to either side
constexpr double kFirstStep_px = 1;  // of the first round
constexpr size_t kMostPhotos = 6;    // of those that see a vertex
constexpr int kLeastTrust = 2;       // of the pixel that shows it
constexpr int kNormalRounds = 3;     // of SmoothNormals: patches are larger than triangles
constexpr double kLeastAgreement = 0.7;
constexpr size_t kGrain = 512;

// What pulls a displacement to the mean of its neighbours', and to 0, as the curvature of the
// photos' agreement pulls it to its peak. The former decides between details and ripples: 2 to 20
// give the demo's surface the same F-score.
constexpr double kStiffness = 5, kRest = 0.002;
// The latter where the surface would fold, so that what is around bends instead. A larger one also
// holds flat parts whose thin triangles turn easily (the demo's table).
constexpr double kHold = 1;
constexpr int kMostHolds = 5;  // times that folds are looked for in a round
constexpr int kRelaxations = 100;
constexpr int kRelaxationsAfterHold = 30;  // few vertices have to change
// Relaxation also ends once no displacement changes by more than this [footprints].
constexpr double kSettled = 0.002;

// The photos that see a vertex best, at most kMostPhotos.
struct Onlookers {
  std::vector<uint32_t> photos;
  double footprint = 0;  // mean of their pixels' [world units]; 0 if fewer than two see the vertex
};

// From the front and closely is best.
Onlookers FindOnlookers(const SurfacePoint& point, std::span<const TexturePhoto> photos) {
  struct Candidate {
    double worth, footprint;
    uint32_t photo;
  };
  std::vector<Candidate> candidates;
  for (uint32_t p = 0; p < photos.size(); ++p) {
    const auto sighting = See(point, photos[p]);
    if (!sighting) continue;
    const size_t pixel = photos[p].Index(int(sighting->pixel.x), int(sighting->pixel.y));
    if (photos[p].trust[pixel] < kLeastTrust) continue;
    candidates.push_back({sighting->facing / sighting->footprint, sighting->footprint, p});
  }
  if (candidates.size() < 2) return {};
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return a.worth > b.worth || (a.worth == b.worth && a.photo < b.photo);
  });
  candidates.resize(std::min(candidates.size(), kMostPhotos));
  Onlookers result;
  for (const Candidate& candidate : candidates) {
    result.photos.push_back(candidate.photo);
    result.footprint += candidate.footprint / double(candidates.size());
  }
  return result;
}

std::vector<Onlookers> OnlookersOf(const TriangleMesh& mesh, std::span<const TexturePhoto> photos) {
  const std::vector<glm::dvec3> normals = SmoothNormals(mesh, kNormalRounds);
  std::vector<Onlookers> result(mesh.positions.size());
  ParallelFor(result.size(), kGrain, [&](size_t begin, size_t end) {
    for (size_t v = begin; v < end; ++v) {
      result[v] = FindOnlookers({glm::dvec3(mesh.positions[v]), normals[v]}, photos);
    }
  });
  return result;
}

// The displacement of a vertex at which its photos agree.
struct Peak {
  double place = 0;   // along the normal [footprints]
  double weight = 0;  // curvature of the agreement there; 0: no such place
};

SurfacePatch PatchAt(const glm::dvec3& center, const glm::dvec3& normal, double footprint) {
  const glm::dvec3 axis = std::abs(normal.z) < 0.7 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
  const glm::dvec3 across = glm::normalize(glm::cross(axis, normal));
  return {center, footprint * across, footprint * glm::cross(normal, across)};
}

Peak FindPeak(const SurfacePoint& point, const Onlookers& onlookers, const PhotoPatches& patches,
              double step_px) {
  if (onlookers.footprint == 0 || !(glm::length(point.normal) > 0)) return {};
  const SurfacePatch patch = PatchAt(point.position, point.normal, onlookers.footprint);
  std::array<double, 2 * kSteps + 1> agreement;
  for (int k = -kSteps; k <= kSteps; ++k) {
    SurfacePatch moved = patch;
    moved.center += (k * step_px * onlookers.footprint) * point.normal;
    agreement[size_t(k + kSteps)] = patches.Agreement(moved, onlookers.photos);
  }
  const auto best =
      size_t(std::max_element(agreement.begin(), agreement.end()) - agreement.begin());
  if (best == 0 || best + 1 == agreement.size() || agreement[best] < kLeastAgreement) return {};
  const double before = agreement[best - 1], after = agreement[best + 1];
  const double bend = 2 * agreement[best] - before - after;
  if (!(bend > 0)) return {};
  return {step_px * (double(best) - kSteps + 0.5 * (after - before) / bend),
          bend / (step_px * step_px)};
}

std::vector<Peak> FindPeaks(const TriangleMesh& mesh, const std::vector<glm::dvec3>& normals,
                            const std::vector<Onlookers>& onlookers, const PhotoPatches& patches,
                            double step_px) {
  std::vector<Peak> peaks(mesh.positions.size());
  ParallelFor(peaks.size(), kGrain, [&](size_t begin, size_t end) {
    for (size_t v = begin; v < end; ++v) {
      const SurfacePoint point{glm::dvec3(mesh.positions[v]), normals[v]};
      peaks[v] = FindPeak(point, onlookers[v], patches, step_px);
    }
  });
  return peaks;
}

// The mean over the other corners of a vertex's triangles.
double MeanAround(size_t v, const TriangleMesh& mesh, const VertexFans& fans,
                  const std::vector<double>& values) {
  const std::span<const uint32_t> fan = fans.At(v);
  double sum = 0;
  for (const uint32_t t : fan) {
    const glm::uvec3& corners = mesh.triangles[t];
    sum += values[corners.x] + values[corners.y] + values[corners.z] - values[v];
  }
  return sum / (2 * double(fan.size()));
}

// Moves the displacements [footprints] of the vertices towards those of the neighbours, the peaks
// and 0, by Gauss-Seidel. Peaks that are some `scale` away from what the neighbours want count
// little (Geman and McClure's estimator): the photos agree on a wrong place there.
void Relax(const TriangleMesh& mesh, const VertexFans& fans, std::span<const Peak> peaks,
           const std::vector<double>& rest, double scale, int rounds,
           std::vector<double>& displacement) {
  double largest = kSettled;
  for (int round = 0; round < rounds && largest >= kSettled; ++round) {
    largest = 0;
    for (size_t v = 0; v < peaks.size(); ++v) {
      if (fans.At(v).empty()) continue;
      const double mean = MeanAround(v, mesh, fans, displacement);
      const double off = (peaks[v].place - mean) / scale;
      const double weight = peaks[v].weight / ((1 + off * off) * (1 + off * off));
      const double before = displacement[v];
      displacement[v] =
          (weight * peaks[v].place + kStiffness * mean) / (weight + kStiffness + rest[v]);
      largest = std::max(largest, std::abs(displacement[v] - before));
    }
  }
}

// Holds the corners of triangles that `after` turns over; false if all of these are held already.
bool HoldFolds(const TriangleMesh& before, const TriangleMesh& after, std::vector<double>& rest) {
  bool found = false;
  for (const glm::uvec3& t : before.triangles) {
    if (glm::dot(DoubleAreaNormal(before, t), DoubleAreaNormal(after, t)) >= 0) continue;
    for (int k = 0; k < 3; ++k) {
      found = found || rest[t[k]] != kHold;
      rest[t[k]] = kHold;
    }
  }
  return found;
}

// Vertices that fewer than two photos see have the mean of the others.
std::vector<double> FootprintsOf(std::span<const Onlookers> onlookers) {
  double sum = 0, count = 0;
  for (const Onlookers& o : onlookers) {
    sum += o.footprint;
    count += o.footprint > 0;
  }
  std::vector<double> footprints;
  for (const Onlookers& o : onlookers) {
    footprints.push_back(o.footprint > 0 || count == 0 ? o.footprint : sum / count);
  }
  return footprints;
}

// `mesh` moved by displacements along normals, except for its border.
TriangleMesh Displaced(const TriangleMesh& mesh, const std::vector<double>& displacement,
                       const std::vector<double>& footprints,
                       const std::vector<glm::dvec3>& normals, const std::vector<bool>& border) {
  TriangleMesh moved = mesh;
  for (size_t v = 0; v < displacement.size(); ++v) {
    if (!border[v]) moved.positions[v] += glm::vec3(displacement[v] * footprints[v] * normals[v]);
  }
  return moved;
}

}  // namespace

AlignedSurface AlignWithPhotos(TriangleMesh start, std::span<TexturePhoto> photos, int rounds) {
  if (rounds == 0) return {std::move(start), 0, 0};
  FindTrust(start, photos);
  const std::vector<Onlookers> onlookers = OnlookersOf(start, photos);
  const std::vector<double> footprints = FootprintsOf(onlookers);
  const PhotoPatches patches(photos);
  const VertexFans fans(start);
  const std::vector<bool> border = BorderVertices(start);
  std::vector<double> rest(start.positions.size(), kRest);
  TriangleMesh moved = start;
  std::vector<bool> agreed(start.positions.size(), false);
  double step_px = kFirstStep_px;
  for (int round = 0; round < rounds; ++round, step_px /= 2) {
    const std::vector<glm::dvec3> normals = SmoothNormals(moved, kNormalRounds);
    const std::vector<Peak> peaks = FindPeaks(moved, normals, onlookers, patches, step_px);
    for (size_t v = 0; v < peaks.size(); ++v) agreed[v] = agreed[v] || peaks[v].weight > 0;
    std::vector<double> displacement;
    for (const Peak& peak : peaks) displacement.push_back(peak.place);
    TriangleMesh next;
    for (int hold = 0; hold < kMostHolds; ++hold) {
      Relax(start, fans, peaks, rest, step_px, hold == 0 ? kRelaxations : kRelaxationsAfterHold,
            displacement);
      next = Displaced(moved, displacement, footprints, normals, border);
      if (!HoldFolds(start, next, rest)) break;
    }
    moved = std::move(next);
  }
  AlignedSurface result{StepBackFromCrossings(start, std::move(moved)),
                        size_t(std::count(agreed.begin(), agreed.end(), true)), 0};
  for (size_t v = 0; v < footprints.size(); ++v) {
    if (!(footprints[v] > 0)) continue;  // no photo sees anything
    const float move = glm::distance(result.mesh.positions[v], start.positions[v]);
    result.mean_move_px += double(move) / footprints[v] / double(footprints.size());
  }
  return result;
}

}  // namespace tetrec
