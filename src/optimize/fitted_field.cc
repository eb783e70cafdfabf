// The field that a run fits; the renderer has it.
#include "optimize/fitted_field.h"

#include "core/error.h"
#include "mesh/boundary.h"
#include "render/seen_colors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace tetrec {
namespace {

// The least density of surfaces on which depth maps agree, in units of DensityOfSurfaces: a third
// of the light is lost along a median edge, or two thirds with few photos. What many photos teach
// is more exact than depth maps.
constexpr double kLeastOfSurfaces = 2, kLeastOfSmallCollection = 5;

}  // namespace

FittedField::FittedField(const OptimizeOptions& options, const Scene& scene,
                         TrainingRenderer& renderer, BatchDrawer& batches, PhotoSight sight,
                         double density_of_surfaces)
    : renderer_(renderer),
      batches_(batches),
      sight_(std::move(sight)),
      keeps_seen_space_empty_(options.seen_space == SpaceContent::kEmpty),
      density_of_surfaces_(density_of_surfaces) {
  if (options.seen_surfaces == SurfaceContent::kKept && std::isfinite(density_of_surfaces)) {
    const double least = sight_.IsOfSmallCollection() ? kLeastOfSmallCollection : kLeastOfSurfaces;
    least_of_surfaces_ = float(std::min(least * density_of_surfaces, options.max_density));
  }
  const glm::dvec3 size = scene.subject_bounds.Size();
  subject_size_ = std::max({size.x, size.y, size.z});
  if (options.camera_space == SpaceContent::kEmpty) camera_space_ = FindCameraSpace(scene);
}

void FittedField::Put(TetMesh mesh, FieldState state) {
  row_rates_ = RatesAt(PlacesOfRows(mesh, state.layout.storage));
  BoundDensities(state);
  PutWithRates(std::move(mesh), state);
}

void FittedField::BoundDensities(FieldState& state) const {
  const Attribute& density = state.layout.density();
  const float empty = BoundsOf(density, 1.0f).least;
  for (size_t row = 0; row < row_rates_.size(); ++row) {
    float& parameter = state.parameters[row * size_t(state.layout.Components()) + kDensityOffset];
    parameter = row_rates_[row].share > 0
                    ? std::max(parameter, ParameterOf(density, row_rates_[row].least_density))
                    : empty;
  }
}

void FittedField::Resume(TetMesh mesh, const FieldState& state, std::vector<RowRates> rates) {
  row_rates_ = std::move(rates);
  PutWithRates(std::move(mesh), state);
}

void FittedField::PutWithRates(TetMesh mesh, const FieldState& state) {
  ++topology_;
  CountEmptied(PlacesOfRows(mesh, state.layout.storage));
  renderer_.SetState(std::move(mesh), state);
  renderer_.SetRowRates(row_rates_);
  harmonics_degree_ = state.layout.HarmonicsDegree();
  storage_ = state.layout.storage;
  batches_.UseFewViews(harmonics_degree_ > 0);
}

void FittedField::PutState(FieldState state) {
  const uint64_t topology = topology_;
  BoundDensities(state);
  PutWithRates(renderer_.TakeMesh(), state);
  topology_ = topology;
}

FieldState FittedField::ReadState() const {
  FieldState state = renderer_.ReadState();
  for (const std::vector<float>* values :
       {&state.parameters, &state.first_moment, &state.second_moment}) {
    if (std::all_of(values->begin(), values->end(), [](float v) { return std::isfinite(v); })) {
      continue;
    }
    throw DataError(
        "the optimisation has diverged: values of the field are infinite or not numbers; force a "
        "fresh run with lower learning rates or a lower upper bound of density (or the defaults)");
  }
  return state;
}

MotionCounts FittedField::MoveVertices(std::span<const glm::vec3> moves) {
  const SafeMotion motion = MoveSafely(mesh(), moves);
  renderer_.MoveVertices(motion.positions);
  return motion.counts;
}

void FittedField::MoveVerticesFreely(std::span<const glm::vec3> moves) {
  std::vector<glm::vec3> positions = mesh().positions;
  for (size_t v = 0; v < positions.size(); ++v) {
    positions[v] += moves[v];
    const float sum = positions[v].x + positions[v].y + positions[v].z;
    if (std::isfinite(sum)) continue;
    throw DataError(
        fmt::format("the motion of vertices has diverged: vertex {} is at ({}, {}, {}); force a "
                    "fresh run with a lower rate of positions, or with safe moves",
                    v, positions[v].x, positions[v].y, positions[v].z));
  }
  renderer_.MoveVertices(positions);
}

std::vector<float> FittedField::RoomOfVertices() const {
  const TetMesh& mesh = this->mesh();
  std::vector<float> room = DistancesToCapsules(mesh.positions, camera_space_);
  if (storage_ == FieldStorage::kCell) {
    // A tet belongs to that space if its centroid does, which moves no farther than its vertices.
    const std::vector<float> of_tet =
        DistancesToCapsules(PlacesOfRows(mesh, storage_), camera_space_);
    for (size_t t = 0; t < mesh.tets.size(); ++t) {
      for (int i = 0; i < 4; ++i) {
        float& least = room[mesh.tets[t][i]];
        least = std::min(least, of_tet[t]);
      }
    }
  }
  const std::vector<uint8_t> on_boundary = BoundaryVertices(mesh);
  for (size_t v = 0; v < room.size(); ++v) {
    if (on_boundary[v]) room[v] = 0.0f;
  }
  return room;
}

std::vector<RowRates> FittedField::RatesAt(std::span<const glm::vec3> places) const {
  const std::vector<uint8_t> has_cameras = InsideCapsules(places, camera_space_);
  const std::vector<PlaceSight> sights = sight_.Of(places);
  std::vector<RowRates> rates(places.size());
  for (size_t row = 0; row < places.size(); ++row) {
    const bool is_seen_empty = keeps_seen_space_empty_ && sights[row].is_empty;
    const bool is_kept_surface = least_of_surfaces_ > 0 && sights[row].is_surface;
    if (is_kept_surface || sights[row].is_of_many) {
      rates[row].kept_density = float(density_of_surfaces_);
    }
    if (has_cameras[row] || is_seen_empty) {
      rates[row].share = 0.0f;
    } else if (is_kept_surface) {
      rates[row].least_density = least_of_surfaces_;
    }
  }
  return rates;
}

uint64_t FittedField::kept_surface_rows() const {
  return uint64_t(std::ranges::count_if(
      row_rates_, [](const RowRates& rates) { return rates.least_density > 0; }));
}

void FittedField::CountEmptied(std::span<const glm::vec3> places) {
  std::vector<glm::vec3> emptied;
  for (size_t row = 0; row < places.size(); ++row) {
    if (row_rates_[row].share == 0.0f) emptied.push_back(places[row]);
  }
  const std::vector<uint8_t> has_cameras = InsideCapsules(emptied, camera_space_);
  emptied_rows_ = uint64_t(std::ranges::count(has_cameras, 1));
  seen_empty_rows_ = emptied.size() - emptied_rows_;
}

}  // namespace tetrec
