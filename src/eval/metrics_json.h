// What the parts of the evaluation share in writing metrics.json.
#pragma once

#include "core/log.h"

#include <nlohmann/json.hpp>

#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace tetrec {

// Null stands for numbers that JSON cannot represent.
inline nlohmann::json Finite(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json();
}
inline nlohmann::json Finite(const std::optional<double>& value) {
  return value ? Finite(*value) : nlohmann::json();
}

// Logs a warning and keeps it for metrics.json and the report.
inline void Warn(std::vector<std::string>& warnings, std::string warning) {
  LogWarning("{}", warning);
  warnings.push_back(std::move(warning));
}

}  // namespace tetrec
