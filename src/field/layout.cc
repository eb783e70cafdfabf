// What each vertex, or each tet, of a field carries.
#include "field/layout.h"

#include "core/error.h"
#include "core/error_context.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tetrec {

const char* RowName(FieldStorage storage) {
  return storage == FieldStorage::kCell ? "tet" : "vertex";
}

int FieldLayout::Components() const {
  int count = 0;
  for (const Attribute& attribute : attributes) count += attribute.components;
  return count;
}

int FieldLayout::HarmonicsDegree() const {
  if (IsStandard() || attributes[2].name != kHarmonicsName) return 0;
  int degree = 1;
  while (degree < kMostHarmonicsDegree && attributes[2] != HarmonicsAttribute(degree)) ++degree;
  return degree;
}

Attribute HarmonicsAttribute(int degree) {
  return {kHarmonicsName, 3 * HarmonicsCount(degree), Activation::kIdentity, RateClass::kHarmonics};
}

Attribute SignedDensity(float scale) {
  return {"density", 1, Activation::kSigned, RateClass::kDensity, scale};
}

Attribute SoftplusDensity(float scale) {
  return {"density", 1, Activation::kSoftplus, RateClass::kDensity, scale};
}

int FieldLayout::OffsetOf(std::string_view name) const {
  int offset = 0;
  for (const Attribute& attribute : attributes) {
    if (attribute.name == name) return offset;
    offset += attribute.components;
  }
  TETREC_CHECK(false, fmt::format("the layout has no attribute '{}'", name));
  return -1;
}

std::vector<const Attribute*> FieldLayout::ByComponent() const {
  std::vector<const Attribute*> all;
  for (const Attribute& attribute : attributes) {
    all.insert(all.end(), size_t(attribute.components), &attribute);
  }
  return all;
}

std::vector<std::string> FieldLayout::ParameterNames() const {
  std::vector<std::string> names;
  for (const Attribute& attribute : attributes) {
    const char* prefix = attribute.activation == Activation::kExp        ? "log "
                         : attribute.activation == Activation::kSigned   ? "signed "
                         : attribute.activation == Activation::kSoftplus ? "softplus "
                                                                         : "";
    for (int i = 0; i < attribute.components; ++i) {
      names.push_back(attribute.components == 1
                          ? prefix + attribute.name
                          : fmt::format("{}{}[{}]", prefix, attribute.name, i));
    }
  }
  return names;
}

namespace {

bool IsDensity(const Attribute& attribute) {
  Attribute without_scale = attribute;
  without_scale.scale = 0;
  return attribute == kDensityAttribute || without_scale == SignedDensity(0) ||
         without_scale == SoftplusDensity(0);
}

// Renderers know the harmonics by their place.
void CheckHarmonics(const FieldLayout& layout) {
  for (size_t i = 2; i < layout.attributes.size(); ++i) {
    const Attribute& attribute = layout.attributes[i];
    if (attribute.name != kHarmonicsName) continue;
    const int degree = layout.HarmonicsDegree();
    if (i == 2 && attribute == HarmonicsAttribute(degree)) continue;
    throw DataError(
        fmt::format("attribute '{}' is number {} with {} components: it must be number 2, with 9, "
                    "24 or 45 components, no activation and its own rate class",
                    kHarmonicsName, i, attribute.components));
  }
}

// Bounds of the scale of density [1 / world unit]; beyond them, values would overflow.
constexpr float kLeastScale = 1e-20f, kLargestScale = 1e20f;

// Only density may have a scale, which the updates of all others do not know. In a cell, signed
// density would have no place at which it changes its sign.
void CheckScales(const FieldLayout& layout) {
  for (const Attribute& attribute : layout.attributes) {
    if (!HasScale(attribute.activation)) continue;
    const bool is_signed = attribute.activation == Activation::kSigned;
    const bool has_scale = attribute.scale >= kLeastScale && attribute.scale <= kLargestScale;
    if (attribute.name == kDensityAttribute.name && has_scale &&
        (!is_signed || layout.storage == FieldStorage::kVertex)) {
      continue;
    }
    const char* form = is_signed ? "signed" : "softplus";
    throw DataError(fmt::format(
        "attribute '{}' is {} with scale {}: only density{} can be {}, with a scale from {} to {}",
        attribute.name, form, attribute.scale, is_signed ? " of vertices" : "", form, kLeastScale,
        kLargestScale));
  }
}

}  // namespace

void CheckLayout(const FieldLayout& layout) {
  const std::vector<Attribute>& attributes = layout.attributes;
  if (attributes.size() < 2 || attributes.size() > kMostAttributes ||
      attributes[0] != kColorAttribute || !IsDensity(attributes[1])) {
    throw DataError(fmt::format(
        "a layout of {} attributes: it must start with colour (3 components) and density (1), and "
        "have {} attributes at most",
        attributes.size(), kMostAttributes));
  }
  for (size_t i = 0; i < attributes.size(); ++i) {
    const Attribute& attribute = attributes[i];
    const bool is_name = !attribute.name.empty() && attribute.name.size() <= kMostNameLetters &&
                         std::all_of(attribute.name.begin(), attribute.name.end(), [](char c) {
                           return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
                         });
    if (!is_name) {
      throw DataError(
          fmt::format("the name of attribute {} is not 1 to {} letters a-z, digits and underscores",
                      i, kMostNameLetters));
    }
    if (attribute.components < 1 || attribute.components > kMostComponents) {
      throw DataError(fmt::format("attribute '{}' has {} components, must have 1 to {}",
                                  attribute.name, attribute.components, kMostComponents));
    }
    if (attribute.activation > Activation::kSoftplus || uint32_t(attribute.rate) >= kRateClasses) {
      throw DataError(fmt::format("attribute '{}' has activation {} and rate class {}: not known",
                                  attribute.name, uint32_t(attribute.activation),
                                  uint32_t(attribute.rate)));
    }
    for (size_t j = 0; j < i; ++j) {
      if (attributes[j].name == attribute.name) {
        throw DataError(fmt::format("the layout has two attributes '{}'", attribute.name));
      }
    }
  }
  CheckHarmonics(layout);
  CheckScales(layout);
}

void AppendLayout(ByteWriter& writer, const FieldLayout& layout) {
  writer.Write(uint32_t(layout.storage == FieldStorage::kCell ? 1 : 0));
  writer.Write(uint32_t(layout.attributes.size()));
  for (const Attribute& attribute : layout.attributes) {
    writer.Write(uint32_t(attribute.name.size()));
    writer.WriteArray(std::span<const char>(attribute.name));
    writer.Write(uint32_t(attribute.components));
    writer.Write(uint32_t(attribute.activation));
    writer.Write(uint32_t(attribute.rate));
    if (HasScale(attribute.activation)) writer.Write(attribute.scale);
  }
}

FieldLayout TakeLayout(ByteReader& reader) {
  FieldLayout layout{.storage = FieldStorage::kVertex, .attributes = {}};
  const uint32_t storage = reader.Read<uint32_t>("storage");
  if (storage > 1) {
    throw DataError(
        fmt::format("{}: storage {} is neither 0 (vertex) nor 1 (cell)", reader.name(), storage));
  }
  if (storage == 1) layout.storage = FieldStorage::kCell;
  const uint32_t count = reader.Read<uint32_t>("the number of attributes");
  // Counts that CheckLayout refuses are cut to one too many: nothing large is read or kept.
  for (uint32_t i = 0; i < std::min(count, uint32_t(kMostAttributes + 1)); ++i) {
    Attribute attribute;
    const uint32_t letters = reader.Read<uint32_t>("the length of an attribute's name");
    if (letters > kMostNameLetters) {
      throw DataError(
          fmt::format("{}: the name of attribute {} has {} letters, must have {} at most",
                      reader.name(), i, letters, kMostNameLetters));
    }
    const std::vector<char> name = reader.ReadArray<char>(letters, "an attribute's name");
    attribute.name.assign(name.begin(), name.end());
    attribute.components = int(std::min(reader.Read<uint32_t>("components"), 1u << 20));
    attribute.activation = Activation(reader.Read<uint32_t>("an activation"));
    attribute.rate = RateClass(reader.Read<uint32_t>("a rate class"));
    if (HasScale(attribute.activation)) attribute.scale = reader.Read<float>("a scale");
    layout.attributes.push_back(std::move(attribute));
  }
  NamingFile(reader.name(), [&] { CheckLayout(layout); });
  return layout;
}

ParameterBounds BoundsOf(const Attribute& attribute, float largest) {
  const bool is_signed = attribute.activation == Activation::kSigned;
  return {is_signed ? kLeastSignedParameter : kLeastLogDensity, ParameterOf(attribute, largest)};
}

float ParameterOf(const Attribute& attribute, float value) {
  if (attribute.activation == Activation::kExp) {
    return value > 0 ? std::max(std::log(value), kLeastLogDensity) : kLeastLogDensity;
  }
  if (!HasScale(attribute.activation)) return value;
  const double of_scale = double(value) / double(attribute.scale);
  if (attribute.activation == Activation::kSigned) return float(std::asinh(of_scale));
  if (!(of_scale > 0)) return kLeastLogDensity;
  // ln(e^x - 1), without overflow.
  return std::max(float(of_scale + std::log(-std::expm1(-of_scale))), kLeastLogDensity);
}

}  // namespace tetrec
