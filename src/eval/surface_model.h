// The surface as a model that fits into the report's page.
#pragma once

#include "eval/run_facts.h"
#include "geometry/rigid3.h"
#include "mesh/triangle_mesh.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace tetrec {

struct SurfaceModel {
  std::vector<uint8_t> glb;  // binary glTF; empty if the surface cannot be shown
  Similarity3 input_from_model;
  std::string note;  // what differs from the surface, or why it cannot be shown; may be empty
};

// surface.glb of the stage, with its texture if it has one, as long as it has at most 6 MB (8 MB as
// text); otherwise `mesh`, the stage's PLY file, with at most 200,000 triangles. `scratch` is a
// folder for a temporary file.
SurfaceModel MakeSurfaceModel(const StageFacts& surface_stage, const TriangleMesh& mesh,
                              const Similarity3& input_from_surface,
                              const std::filesystem::path& scratch);

}  // namespace tetrec
