// The choice of what density is learned by, and whether its values may be negative.
#pragma once

#include "core/words.h"
#include "field/radiance_field.h"
#include "mesh/tet_mesh.h"

namespace tetrec {

// With values of any sign, a surface may lie anywhere inside a tet (shared/segment_cut.glsl.h);
// with positive values, a tet with one dense vertex is opaque almost up to its other vertices. A
// step of e^parameter multiplies all densities alike, which is coarse for dense ones; a step of
// softplus adds to them.
enum class DensityForm {
  kAuto,      // signed for pictures with alpha if vertices have the attributes, otherwise positive
  kPositive,  // e^parameter
  kSoftplus,  // positive; e^parameter where it is low, linear in the parameter where it is high
  kSigned,    // of any sign; what is rendered is the positive part
};
template <>
inline constexpr auto kWords<DensityForm> =
    std::to_array<Word<DensityForm>>({{DensityForm::kAuto, "auto"},
                                      {DensityForm::kPositive, "positive"},
                                      {DensityForm::kSoftplus, "softplus"},
                                      {DensityForm::kSigned, "signed"}});

// The density that makes a fifth of an optical depth over the median edge of a mesh, which is
// between what is best for opaque subjects (a half) and for volumes of soft density (a twentieth).
// What is denser is a surface rather than fog [1 / world unit]. Infinity for a mesh without tets.
double DensityOfSurfaces(const TetMesh& mesh);

// The density attribute of a fit that begins with `start`. The scale of signed density is
// DensityOfSurfaces; that of softplus is 15 times as much, three optical depths over the median
// edge.
Attribute LearnedDensity(DensityForm form, bool has_alpha, const RadianceField& start);

}  // namespace tetrec
