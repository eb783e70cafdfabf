// The view of a scene that a rendered picture shows.
#pragma once

#include "scene/scene.h"

#include <algorithm>
#include <string>

namespace tetrec {

// nullptr if the scene has no view of this name.
inline const View* FindView(const Scene& scene, const std::string& name) {
  const auto found = std::find_if(scene.views.begin(), scene.views.end(),
                                  [&](const View& view) { return view.name == name; });
  return found == scene.views.end() ? nullptr : &*found;
}

}  // namespace tetrec
