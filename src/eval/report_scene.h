// The report's 3-D scene: surface, cameras and sparse points.
#pragma once

#include "eval/surface_model.h"
#include "scene/scene.h"

#include <optional>
#include <string>

namespace tetrec {

// HTML of the section: a canvas, its controls, and all data as attributes in base64. `surface` may
// be null; without a scene the input's coordinates are the world. Empty if there is nothing to
// show, or a sentence that names the reason if the build had no three.js.
std::string SceneSection(const std::optional<Scene>& scene, const SurfaceModel* surface);

// three.js with its licence, and the script of the section; empty if the build had no three.js.
std::string SceneScript();

}  // namespace tetrec
