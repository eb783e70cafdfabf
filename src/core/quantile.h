// Quantiles of a list of numbers.
#pragma once

#include "core/error.h"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace tetrec {

// The value that has `rank` values before it when all are sorted.
inline double ValueOfRank(std::vector<double> values, size_t rank) {
  TETREC_CHECK(rank < values.size(), "rank of a value");
  const auto at = values.begin() + std::ptrdiff_t(rank);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

// Requires at least one value; `share` from 0 to 1, 0.5 is the median.
inline double Quantile(std::vector<double> values, double share) {
  TETREC_CHECK(!values.empty(), "no values");
  const size_t rank = size_t(share * double(values.size() - 1));
  return ValueOfRank(std::move(values), rank);
}

// The mean of the two middle values if their number is even; 0 without any.
inline double Median(const std::vector<double>& values) {
  const size_t count = values.size();
  if (count == 0) return 0;
  return (ValueOfRank(values, (count - 1) / 2) + ValueOfRank(values, count / 2)) / 2;
}

// The value at which the weights of all smaller values reach `share` of the total. Pairs of value
// and weight, at least one.
inline double WeightedQuantile(std::vector<std::pair<double, double>> weighted, double share) {
  TETREC_CHECK(!weighted.empty(), "no values");
  std::sort(weighted.begin(), weighted.end());
  double total = 0, sum = 0;
  for (const auto& [value, weight] : weighted) total += weight;
  for (const auto& [value, weight] : weighted) {
    if ((sum += weight) >= share * total) return value;
  }
  return weighted.back().first;
}

}  // namespace tetrec
