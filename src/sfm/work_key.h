// Names of cached work.
#pragma once

#include "core/file.h"

#include <nlohmann/json.hpp>

#include <string>

namespace tetrec {

// A short name that depends on everything that determines the work.
inline std::string WorkKey(const nlohmann::json& inputs) {
  const std::string text = inputs.dump();
  return Sha256({reinterpret_cast<const uint8_t*>(text.data()), text.size()}).substr(0, 16);
}

}  // namespace tetrec
