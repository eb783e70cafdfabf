// What each vertex, or each tet, of a field carries: the one description from which buffers,
// optimiser, checkpoints, refinement and file formats are derived.
#pragma once

#include "core/file.h"
#include "core/words.h"
#include "shared/activation.glsl.h"

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace tetrec {

enum class FieldStorage {
  kVertex,  // one row of attributes per vertex, linear inside each tet
  kCell,    // one row per tet, constant inside
};
template <>
inline constexpr auto kWords<FieldStorage> = std::to_array<Word<FieldStorage>>(
    {{FieldStorage::kVertex, "vertex"}, {FieldStorage::kCell, "cell"}});

// "vertex" or "tet": what the rows belong to.
const char* RowName(FieldStorage storage);

// How the parameter that is learned becomes the value that is rendered. Shaders and files use the
// numbers (kActivation... of shared/activation.glsl.h).
enum class Activation : uint32_t {
  kIdentity,  // the parameter itself
  kColor,     // the parameter itself, which an update clamps to [0, 1]
  kExp,       // e^parameter; a value >= 0 that interpolates linearly, its parameter does not
  kSigned,    // scale * sinh(parameter); a value of any sign that interpolates linearly
  kSoftplus,  // scale * ln(1 + e^parameter); as kExp below `scale`, linear in the parameter above
};

static_assert(uint32_t(Activation::kIdentity) == kActivationIdentity &&
              uint32_t(Activation::kColor) == kActivationColor &&
              uint32_t(Activation::kExp) == kActivationExp &&
              uint32_t(Activation::kSigned) == kActivationSigned &&
              uint32_t(Activation::kSoftplus) == kActivationSoftplus);

// Which learning rate an attribute follows. An attribute with a rate of its own needs a class here
// and its rate in AdamUpdate.
enum class RateClass : uint32_t { kColor, kDensity, kHarmonics };
constexpr int kRateClasses = 3;

struct Attribute {
  std::string name;  // 1 .. 32 letters a-z, digits and underscores
  int components = 1;
  Activation activation = Activation::kIdentity;
  RateClass rate = RateClass::kColor;
  float scale = 0.0f;  // of kSigned and kSoftplus, above 0; 0 for the others
  bool operator==(const Attribute&) const = default;
};

constexpr size_t kMostAttributes = 8, kMostNameLetters = 32;
constexpr int kMostComponents = 64;  // of an attribute

// Every layout starts with these two, which all renderers read; components before and behind them
// are known by their offsets.
inline const Attribute kColorAttribute{"color", 3, Activation::kColor, RateClass::kColor};
inline const Attribute kDensityAttribute{"density", 1, Activation::kExp, RateClass::kDensity};
// Density whose values may be negative; what is rendered is their positive part
// (shared/segment_cut.glsl.h). Below `scale` [1 / world unit] parameters are linear in values.
Attribute SignedDensity(float scale);
// Density of positive values. Where it is far below `scale` [1 / world unit], its parameter is its
// logarithm in units of `scale`; where it is far above, its multiple of `scale`.
Attribute SoftplusDensity(float scale);
constexpr bool HasScale(Activation activation) {
  return activation == Activation::kSigned || activation == Activation::kSoftplus;
}
constexpr int kColorOffset = 0, kDensityOffset = 3, kStandardComponents = 4;

// View-dependent colour (shared/harmonics.glsl.h): red, green and blue coefficients of each
// function in turn. It comes right behind the standard attributes.
inline constexpr const char* kHarmonicsName = "harmonics";
inline constexpr int kMostHarmonicsDegree = 3;
// The number of functions of degrees 1 to `degree`, and the attribute of their coefficients.
constexpr int HarmonicsCount(int degree) { return (degree + 1) * (degree + 1) - 1; }
Attribute HarmonicsAttribute(int degree);

struct FieldLayout {
  FieldStorage storage = FieldStorage::kVertex;
  std::vector<Attribute> attributes = {kColorAttribute, kDensityAttribute};

  int Components() const;  // of a row
  // First component of the attribute; TETREC_CHECKs that there is one of that name.
  int OffsetOf(std::string_view name) const;
  bool IsStandard() const { return attributes.size() == 2; }
  // Moments of a row (FieldState).
  static constexpr int FirstMoments() { return kStandardComponents; }
  int SecondMoments() const { return kStandardComponents + int(attributes.size()) - 2; }
  const Attribute& density() const { return attributes[1]; }
  // The degree of view-dependent colour; 0: there is none.
  int HarmonicsDegree() const;
  // The attribute of each component of a row.
  std::vector<const Attribute*> ByComponent() const;
  // "color[0]", "color[1]", "color[2]", "log density": the parameters of a row.
  std::vector<std::string> ParameterNames() const;
  bool operator==(const FieldLayout&) const = default;
};

// Throws DataError that names the attribute and what is wrong with it.
void CheckLayout(const FieldLayout& layout);

// The form in which files contain a layout, little endian: u32 storage (0 vertex, 1 cell), u32
// number of attributes, then for each u32 length of its name, the name, u32 components, u32
// activation (0 identity, 1 colour, 2 exponential, 3 signed, 4 softplus), u32 rate class (0 colour,
// 1 density, 2 harmonics), and of a signed or softplus attribute the f32 scale.
void AppendLayout(ByteWriter& writer, const FieldLayout& layout);
// Throws DataError.
FieldLayout TakeLayout(ByteReader& reader);

// Below this logarithm float's denormals are near, and a density and its gradient would stay 0 for
// ever: the parameter of density 0, and the least that an update leaves.
constexpr float kLeastLogDensity = -80.0f;

// The least that an update leaves of a signed parameter: -10 times the scale. Further below 0, a
// vertex would need long to return, and would cut the surface close to its neighbours.
constexpr float kLeastSignedParameter = -3.0f;

// Bounds that an update keeps of a parameter whose value is `largest` at most.
struct ParameterBounds {
  float least, largest;
};
ParameterBounds BoundsOf(const Attribute& attribute, float largest);

template <class Real>
Real ValueOf(const Attribute& attribute, Real parameter) {
  return ActivatedValue(int(attribute.activation), parameter, Real(attribute.scale));
}
// dvalue/dparameter.
template <class Real>
Real SlopeOf(const Attribute& attribute, Real parameter) {
  return ActivationSlope(int(attribute.activation), parameter, Real(attribute.scale));
}
float ParameterOf(const Attribute& attribute, float value);

}  // namespace tetrec
