// The files of a surface and its field for other programs.
#include "surface/export.h"

#include "core/error.h"
#include "core/log.h"
#include "core/option_range.h"
#include "core/progress.h"
#include "field/field_export.h"
#include "geometry/checked_geometry.h"
#include "surface/glb.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace tetrec {
namespace {

glm::dvec3 Point(const std::vector<double>& numbers, size_t first) {
  return {numbers[first], numbers[first + 1], numbers[first + 2]};
}

constexpr const char *kTextureFile = "surface.png", *kMaterialFile = "surface.mtl";

void WriteSurface(const TexturedMesh& surface, const ExportOptions& options, Stage& stage) {
  const bool textured = !surface.texture.pixels.empty();
  if (textured) WriteImage(stage.Output(kTextureFile), surface.texture);
  WriteTriangleMeshPly(stage.Output("surface.ply"), surface.mesh, textured ? kTextureFile : "");
  if (options.Wants(ExportFormat::kStl)) {
    WriteTriangleMeshStl(stage.Output("surface.stl"), surface.mesh);
  }
  const bool obj = options.Wants(ExportFormat::kObj), glb = options.Wants(ExportFormat::kGlb);
  if (!obj && !glb) return;
  const TriangleMesh turned = Transformed(surface.mesh, YUpFromExport(options));
  if (obj && textured) WriteTextureMaterial(stage.Output(kMaterialFile), kTextureFile);
  if (obj) {
    WriteTriangleMeshObj(stage.Output("surface.obj"), turned, textured ? kMaterialFile : "");
  }
  if (glb) WriteTriangleMeshGlb(stage.Output("surface.glb"), turned, surface.texture);
}

bool WantsField(const ExportOptions& options) {
  return options.Wants(ExportFormat::kVtu) || options.Wants(ExportFormat::kMedit) ||
         options.Wants(ExportFormat::kGmsh);
}

void WriteField(const RadianceField& field_in_world, const Similarity3& export_from_world,
                const ExportOptions& options, Stage& stage) {
  if (!WantsField(options)) return;
  const RadianceField field = MovedForExport(field_in_world, export_from_world, options.Crop());
  LogInfo("field: {} of {} tets are exported", WithThousands(field.mesh.tets.size()),
          WithThousands(field_in_world.mesh.tets.size()));
  stage.Count("exported_tets", field.mesh.tets.size());
  if (options.Wants(ExportFormat::kVtu)) WriteVtu(stage.Output("field.vtu"), field);
  if (options.Wants(ExportFormat::kMedit)) WriteMedit(stage.Output("field.mesh"), field.mesh);
  if (options.Wants(ExportFormat::kGmsh)) WriteGmsh(stage.Output("field.msh"), field);
}

}  // namespace

void ExportOptions::Check() const {
  CheckRange("scale", scale, 1e-9, 1e9);
  if (!known_distance.empty()) {
    CheckAboveZero("known_distance", known_distance[6]);
    if (!(Scale() >= 1e-9 && Scale() <= 1e9)) {
      throw UsageError(fmt::format("known_distance is {}; expected two different points",
                                   fmt::join(known_distance, ",")));
    }
  }
  if (!crop.empty() && !glm::all(glm::lessThan(Crop()->min, Crop()->max))) {
    throw UsageError(
        fmt::format("crop is {}; expected x0,y0,z0,x1,y1,z1 with x0 < x1, y0 < y1 and z0 < z1",
                    fmt::join(crop, ",")));
  }
}

bool ExportOptions::Wants(ExportFormat format) const {
  return std::ranges::find(formats, format) != formats.end();
}

double ExportOptions::Scale() const {
  if (known_distance.empty()) return scale;
  return known_distance[6] / glm::distance(Point(known_distance, 0), Point(known_distance, 3));
}

std::optional<Bounds3> ExportOptions::Crop() const {
  if (crop.empty()) return std::nullopt;
  return Bounds3{Point(crop, 0), Point(crop, 3)};
}

Similarity3 ExportFromWorld(const ExportOptions& options, const Similarity3& input_from_world) {
  const Similarity3 scaled{options.Scale(), glm::dmat3(1.0), glm::dvec3(0)};
  return options.coordinates == ExportCoordinates::kInput ? scaled * input_from_world : scaled;
}

Similarity3 InputFromExport(const ExportOptions& options, const Similarity3& input_from_world) {
  return input_from_world * ExportFromWorld(options, input_from_world).Inverse();
}

Similarity3 YUpFromExport(const ExportOptions& options) {
  if (options.coordinates == ExportCoordinates::kInput) return {};
  return {1.0, glm::dmat3({1, 0, 0}, {0, 0, -1}, {0, 1, 0}), glm::dvec3(0)};
}

void CheckFloatsSuffice(const ExportOptions& options, const Similarity3& input_from_world,
                        const Bounds3& subject_in_world) {
  const Similarity3 export_from_world = ExportFromWorld(options, input_from_world);
  const glm::dvec3 &low = subject_in_world.min, &high = subject_in_world.max;
  Bounds3 exported;
  for (int corner = 0; corner < 8; ++corner) {
    exported.Add(export_from_world * glm::dvec3((corner & 1) ? high.x : low.x,
                                                (corner & 2) ? high.y : low.y,
                                                (corner & 4) ? high.z : low.z));
  }
  if (StepOfFloats(exported) <= kLargestStepOfFloats) return;
  throw DataError(fmt::format(
      "the subject, {:.4g} in diagonal, is too far from 0 in the input's coordinates, around "
      "{:.6g},{:.6g},{:.6g}, for files of 32-bit floats; leave out --coordinates input and apply "
      "input_from_surface of manifest.json",
      exported.Diagonal(), exported.Center().x, exported.Center().y, exported.Center().z));
}

void CheckCropHasTets(const ExportOptions& options, const Similarity3& input_from_world,
                      const TetMesh& mesh_in_world) {
  const std::optional<Bounds3> crop = options.Crop();
  if (!crop || !WantsField(options)) return;
  const Similarity3 export_from_world = ExportFromWorld(options, input_from_world);
  const auto is_inside = [&](const glm::uvec4& tet) {
    for (int i = 0; i < 4; ++i) {
      const glm::dvec3 corner(mesh_in_world.positions[tet[i]]);
      if (!crop->Contains(export_from_world * corner)) return false;
    }
    return true;
  };
  if (std::any_of(mesh_in_world.tets.begin(), mesh_in_world.tets.end(), is_inside)) return;
  throw DataError(
      fmt::format("no whole tet of the field is inside the crop {}; choose a larger box, or none "
                  "of vtu, mesh and msh as formats",
                  fmt::join(options.crop, ",")));
}

void WriteExports(const TexturedMesh& surface, const RadianceField& field_in_world,
                  const Similarity3& input_from_world, const ExportOptions& options, Stage& stage) {
  const Similarity3 export_from_world = ExportFromWorld(options, input_from_world);
  stage.Note("coordinates", Name(options.coordinates));
  stage.Note("input_from_surface", ToJson(InputFromExport(options, input_from_world)));
  WriteField(field_in_world, export_from_world, options, stage);
  WriteSurface(surface, options, stage);
}

}  // namespace tetrec
