// Quantiles of a list of numbers.
#pragma once

#include "core/error.h"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace tetrec {

// Of at least one value; `share` 0 to 1, 0.5: the median.
inline double Quantile(std::vector<double> values, double share) {
  TETREC_CHECK(!values.empty(), "no values");
  const auto at = values.begin() + std::ptrdiff_t(share * double(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace tetrec
