// The choice between density of positive values and of either sign.
#pragma once

#include "core/words.h"
#include "field/radiance_field.h"

namespace tetrec {

// With values of any sign, a surface may lie anywhere inside a tet (shared/segment_cut.glsl.h);
// with positive values, a tet with one dense vertex is opaque almost up to its other vertices.
enum class DensityForm {
  kAuto,      // signed for pictures with alpha if vertices have the attributes, otherwise positive
  kPositive,  // e^parameter
  kSigned,    // of any sign; what is rendered is the positive part
};
template <>
inline constexpr auto kWords<DensityForm> =
    std::to_array<Word<DensityForm>>({{DensityForm::kAuto, "auto"},
                                      {DensityForm::kPositive, "positive"},
                                      {DensityForm::kSigned, "signed"}});

// The density attribute of a fit that begins with `start`. The scale of signed density makes a
// fifth of an optical depth over the median edge of the mesh.
Attribute LearnedDensity(DensityForm form, bool has_alpha, const RadianceField& start);

}  // namespace tetrec
