// The cases of a stress test: runs on a scene that is damaged, or by unusual options, each beside a
// clean twin.
#pragma once

#include "field/radiance_field.h"
#include "stability/picture_damage.h"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace tetrec {

struct StressCase {
  std::string name;  // of its folder: "one-black-photo"
  std::string what;  // a phrase for the report
  std::string twin;  // the name of the clean case; empty if this one is clean
  std::string gone;  // what no method could know any more, so that a loss is no fault; or empty
  std::vector<std::string> tetrahedralize, optimize;               // options
  std::function<void(SceneWithImages&)> damage_scene;              // none: the scene as it is
  std::function<void(RadianceField&, const Scene&)> damage_start;  // none: the start as it is
  bool needs_points = false;  // only where the scene has sparse points
  bool is_short = false;      // part of the short form
};

// Clean cases come before those that refer to them. All run `iterations` steps, except those about
// the length of a run.
std::vector<StressCase> StressCases(uint64_t iterations, uint64_t seed);

}  // namespace tetrec
