// The field that a run fits; the renderer has it.
#pragma once

#include "field/field_state.h"
#include "mesh/safe_motion.h"
#include "mesh/tet_mesh.h"
#include "optimize/batches.h"
#include "optimize/camera_space.h"
#include "optimize/optimize_options.h"
#include "optimize/photo_sight.h"
#include "render/training_renderer.h"
#include "scene/scene.h"

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace tetrec {

// Whatever state it is given, there is no density in the space of the cameras and in what photos
// see to be empty, and none grows there. Surfaces on which depth maps agree never become
// transparent: hollows would show what changes from photo to photo, such as the light on a subject
// that turns. Others that many photos see do not decay: decay would let light through them wherever
// the photos show the same colour behind.
class FittedField {
 public:
  // Tells `batches` whether colours depend on the view. What has `density_of_surfaces` or more is
  // a surface [1 / world unit].
  FittedField(const OptimizeOptions& options, const Scene& scene, TrainingRenderer& renderer,
              BatchDrawer& batches, PhotoSight sight = {},
              double density_of_surfaces = std::numeric_limits<double>::infinity());

  void Put(TetMesh mesh, FieldState state);
  void PutState(FieldState state);  // of the same mesh, whose rows keep their rates
  // A field that was put before, with the row_rates() that it had: those of Put would be those of
  // the places to which vertices have moved since.
  void Resume(TetMesh mesh, const FieldState& state, std::vector<RowRates> rates);
  // Each by its move or a part of it (MoveSafely).
  MotionCounts MoveVertices(std::span<const glm::vec3> moves);
  // Each by its move, whatever becomes of the tets. Throws DataError, with the remedy, if a
  // position is not finite then.
  void MoveVerticesFreely(std::span<const glm::vec3> moves);
  // (V) How far each vertex may move in all [world units], so that the boundary and what is in the
  // space of the cameras stay, and nothing enters that space.
  std::vector<float> RoomOfVertices() const;
  // Another number after each Put.
  uint64_t topology() const { return topology_; }
  // Throws DataError, with the remedy, if the fit has diverged: not all values are finite.
  FieldState ReadState() const;
  // Gives the mesh away, and frees what the field takes until the next Put.
  TetMesh TakeMesh() { return renderer_.TakeMesh(); }

  const TetMesh& mesh() const { return renderer_.mesh(); }
  const std::vector<RowRates>& row_rates() const { return row_rates_; }
  const PhotoSight& sight() const { return sight_; }
  double subject_size() const { return subject_size_; }  // its longest side [world units]
  int harmonics_degree() const { return harmonics_degree_; }
  // In the space of the cameras, and elsewhere in what photos see to be empty.
  uint64_t emptied_rows() const { return emptied_rows_; }
  uint64_t seen_empty_rows() const { return seen_empty_rows_; }
  // At surfaces that never become transparent.
  uint64_t kept_surface_rows() const;

 private:
  // Rows in space that is empty have a share of 0.
  std::vector<RowRates> RatesAt(std::span<const glm::vec3> places) const;
  // Makes densities agree with row_rates_.
  void BoundDensities(FieldState& state) const;
  void PutWithRates(TetMesh mesh, const FieldState& state);
  void CountEmptied(std::span<const glm::vec3> places);

  TrainingRenderer& renderer_;
  BatchDrawer& batches_;
  std::vector<Capsule> camera_space_;
  PhotoSight sight_;
  bool keeps_seen_space_empty_;
  double density_of_surfaces_;
  float least_of_surfaces_ = 0;  // on which depth maps agree; 0: they are learned
  double subject_size_ = 0;
  std::vector<RowRates> row_rates_;
  uint64_t topology_ = 0;
  int harmonics_degree_ = 0;
  FieldStorage storage_ = FieldStorage::kVertex;
  uint64_t emptied_rows_ = 0;
  uint64_t seen_empty_rows_ = 0;
};

}  // namespace tetrec
