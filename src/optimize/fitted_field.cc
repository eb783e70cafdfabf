// The field that a run fits: its mesh here, its rows and moments on the renderer.
#include "optimize/fitted_field.h"

#include "mesh/boundary.h"
#include "render/seen_colors.h"

namespace tetrec {

FittedField::FittedField(const OptimizeOptions& options, const Scene& scene,
                         TrainingRenderer& renderer, BatchDrawer& batches)
    : renderer_(renderer), batches_(batches) {
  if (options.camera_space == CameraSpace::kEmpty) camera_space_ = FindCameraSpace(scene);
}

void FittedField::Put(TetMesh mesh, FieldState state) {
  mesh_ = std::move(mesh);
  ++topology_;
  PutState(std::move(state));
}

MotionCounts FittedField::MoveVertices(std::span<const glm::vec3> moves) {
  const MotionCounts counts = MoveSafely(mesh_, moves);
  renderer_.MoveVertices(mesh_.positions);
  return counts;
}

std::vector<uint8_t> FittedField::VerticesThatStay() const {
  std::vector<uint8_t> stays = BoundaryVertices(mesh_);
  if (camera_space_.empty()) return stays;
  const std::vector<uint8_t> is_empty = InsideCapsules(mesh_.positions, camera_space_);
  for (size_t v = 0; v < stays.size(); ++v) stays[v] |= is_empty[v];
  return stays;
}

void FittedField::PutState(FieldState state) {
  const std::vector<float> rate_shares = EmptyCameraSpace(state);
  renderer_.SetState(mesh_, state);
  renderer_.SetRateShares(rate_shares);
  harmonics_degree_ = state.layout.HarmonicsDegree();
  batches_.UseFewViews(harmonics_degree_ > 0);
}

std::vector<float> FittedField::EmptyCameraSpace(FieldState& state) {
  std::vector<float> rate_shares(state.rows(), 1.0f);
  if (camera_space_.empty()) return rate_shares;
  emptied_rows_ = 0;
  const float least = BoundsOf(state.layout.density(), 1.0f).least;
  const std::vector<uint8_t> is_empty =
      InsideCapsules(PlacesOfRows(mesh_, state.layout.storage), camera_space_);
  for (size_t row = 0; row < is_empty.size(); ++row) {
    if (!is_empty[row]) continue;
    ++emptied_rows_;
    rate_shares[row] = 0.0f;
    state.parameters[row * size_t(state.layout.Components()) + kDensityOffset] = least;
  }
  return rate_shares;
}

}  // namespace tetrec
