// Checks of values that the readers of binary and of text COLMAP models share.
#pragma once

#include "colmap/model.h"

#include <string>

namespace tetrec::internal {

// True if the value is finite and not implausibly large.
bool IsSane(double value);

// The message for a camera model, given by its number or name, that is not one of LensModel; says
// how COLMAP can replace it.
std::string ComplaintOnUnknownModel(const std::string& model);

// What is wrong; empty if nothing is.
std::string ComplaintOnSize(uint64_t width, uint64_t height);
std::string ComplaintOnQuaternion(const double (&wxyz)[4]);
std::string ComplaintOnImageName(const std::string& name);

Rigid3 PoseOf(const double (&wxyz)[4], const glm::dvec3& translation);

}  // namespace tetrec::internal
