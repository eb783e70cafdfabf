// Fields that wait on disk while a run tries another one.
#pragma once

#include "optimize/fitted_field.h"
#include "optimize/vertex_motion.h"

#include <filesystem>

namespace tetrec {

// Writes mesh and state, with moments and rates.
void SaveField(const std::filesystem::path& file, const FittedField& field);

// Replaces the field by a saved one, which gets the present field's degree of harmonics. The
// present field is freed before the other one takes memory.
void RestoreField(const std::filesystem::path& file, FittedField& field);

// A field that waits on disk while another one learns, with the state of its motion.
class WaitingField {
 public:
  WaitingField(std::filesystem::path file, const FittedField& field, const VertexMotion& motion);
  void PutBack(FittedField& field, VertexMotion& motion) const;

 private:
  std::filesystem::path file_;
  MotionState motion_;
};

}  // namespace tetrec
