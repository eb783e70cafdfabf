// Chooses between the stage's GLB file and a decimated copy of its mesh.
#include "eval/surface_model.h"

#include "core/error.h"
#include "core/file.h"
#include "core/manifest.h"
#include "core/progress.h"
#include "surface/export.h"
#include "surface/glb.h"
#include "surface/simplify.h"

#include <fmt/format.h>

namespace tetrec {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

constexpr uint64_t kMostBytes = 6'000'000;
constexpr uint64_t kMostTriangles = 200'000;  // about 22 bytes each

// Bytes of surface.glb among the stage's outputs; 0 without it.
uint64_t GlbBytes(const StageFacts& surface) {
  for (const json& output : surface.manifest.value("outputs", json::array())) {
    if (TextOrEmpty(output, "path") == "surface.glb") {
      return output.value("bytes", uint64_t{0});
    }
  }
  return 0;
}

// From surface.glb to surface.ply.
Similarity3 SurfaceFromGlb(const StageFacts& surface) {
  const json notes = surface.manifest.value("notes", json());
  ExportOptions options;
  if (TextOrEmpty(notes, "coordinates") == Name(ExportCoordinates::kInput)) {
    options.coordinates = ExportCoordinates::kInput;
  }
  return YUpFromExport(options).Inverse();
}

}  // namespace

SurfaceModel MakeSurfaceModel(const StageFacts& surface_stage, const TriangleMesh& mesh,
                              const Similarity3& input_from_surface, const fs::path& scratch) {
  if (mesh.triangles.empty()) return {{}, {}, "The surface has no triangle."};
  const uint64_t bytes = GlbBytes(surface_stage);
  if (bytes > 0 && bytes <= kMostBytes) {
    return {ReadBytes(surface_stage.folder / "surface.glb", kMostBytes),
            input_from_surface * SurfaceFromGlb(surface_stage), ""};
  }
  SurfaceModel model{{}, input_from_surface, ""};
  try {
    TriangleMesh fewer;
    if (mesh.triangles.size() > kMostTriangles) fewer = Decimate(mesh, kMostTriangles);
    const TriangleMesh& shown = fewer.triangles.empty() ? mesh : fewer;
    const fs::path file = scratch / "surface.glb";
    fs::create_directories(scratch);
    WriteTriangleMeshGlb(file, shown);
    model.glb = ReadBytes(file, 2 * kMostBytes);
    if (bytes > kMostBytes && !mesh.corner_coordinates.empty()) {
      model.note = "Shown in the colours of its vertices, because its texture is too large here. ";
    }
    if (shown.triangles.size() < mesh.triangles.size()) {
      model.note +=
          fmt::format("Shown with {} of its {} triangles.", WithThousands(shown.triangles.size()),
                      WithThousands(mesh.triangles.size()));
    }
  } catch (const DataError& error) {
    model.glb.clear();
    model.note = fmt::format("The surface is too large for this page: {}.", error.what());
  }
  return model;
}

}  // namespace tetrec
