// Fields that wait on disk, in the format of a checkpoint.
#include "optimize/field_on_disk.h"

#include "optimize/checkpoint.h"
#include "render/seen_colors.h"

#include <utility>

namespace tetrec {

void SaveField(const std::filesystem::path& file, const FittedField& field) {
  Checkpoint checkpoint;
  checkpoint.mesh = field.mesh();
  checkpoint.state = field.ReadState();
  checkpoint.row_rates = field.row_rates();
  WriteCheckpoint(file, checkpoint);
}

void RestoreField(const std::filesystem::path& file, FittedField& field) {
  field.TakeMesh();
  Checkpoint checkpoint = ReadCheckpoint(file);
  field.Resume(std::move(checkpoint.mesh),
               WithHarmonics(checkpoint.state, field.harmonics_degree()),
               std::move(checkpoint.row_rates));
}

WaitingField::WaitingField(std::filesystem::path file, const FittedField& field,
                           const VertexMotion& motion)
    : file_(std::move(file)), motion_(motion.state()) {
  SaveField(file_, field);
}

void WaitingField::PutBack(FittedField& field, VertexMotion& motion) const {
  RestoreField(file_, field);
  motion.Resume(motion_);
}

}  // namespace tetrec
