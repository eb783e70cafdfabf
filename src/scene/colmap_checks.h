// What both readers of COLMAP models, of binary and of text, expect of the values.
#pragma once

#include "scene/colmap_model.h"

#include <span>
#include <string>

namespace tetrec::internal {

// By COLMAP's numbers.
struct ColmapLensKind {
  const char* name;
  int focal_lengths;  // the first of the parameters: of both axes, or of each
  int params;
};
std::span<const ColmapLensKind> ColmapLensKinds();

// Finite, and not so large that it must be a number gone astray.
bool IsSane(double value);

// What is wrong with a camera model, by its number or its name, that is none of these.
std::string ComplaintOnLens(const std::string& lens);

// What is wrong; empty where nothing is.
std::string ComplaintOnSize(uint64_t width, uint64_t height);
// Of a camera with its parameters: a focal length that is none, an EUCM lens that does not bend.
std::string ComplaintOnParams(const ColmapCamera& camera);
std::string ComplaintOnQuaternion(const double (&wxyz)[4]);
std::string ComplaintOnPictureName(const std::string& name);

Rigid3 PoseOf(const double (&wxyz)[4], const glm::dvec3& translation);

}  // namespace tetrec::internal
