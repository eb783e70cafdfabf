// Layouts with an attribute that nothing but these tests knows: what knows layouts must carry it.
#pragma once

#include "field/layout.h"

namespace tetrec {

inline const Attribute kExtraAttribute{"extra", 5, Activation::kIdentity, RateClass::kColor};
inline const FieldLayout kCellLayout{.storage = FieldStorage::kCell};

inline FieldLayout WithExtra(FieldLayout layout) {
  layout.attributes.push_back(kExtraAttribute);
  return layout;
}

}  // namespace tetrec
