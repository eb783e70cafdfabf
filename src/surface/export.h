// The files of a surface and its field for other programs, and the frame that they are in.
#pragma once

#include "core/stage.h"
#include "core/words.h"
#include "field/radiance_field.h"
#include "geometry/bounds3.h"
#include "geometry/rigid3.h"
#include "surface/texture.h"

#include <optional>
#include <vector>

namespace tetrec {

enum class ExportFormat { kPly, kObj, kGlb, kStl, kVtu, kMedit, kGmsh, kColmap, kTransforms };
template <>
inline constexpr auto kWords<ExportFormat> =
    std::to_array<Word<ExportFormat>>({{ExportFormat::kPly, "ply"},
                                       {ExportFormat::kObj, "obj"},
                                       {ExportFormat::kGlb, "glb"},
                                       {ExportFormat::kStl, "stl"},
                                       {ExportFormat::kVtu, "vtu"},
                                       {ExportFormat::kMedit, "mesh"},
                                       {ExportFormat::kGmsh, "msh"},
                                       {ExportFormat::kColmap, "colmap"},
                                       {ExportFormat::kTransforms, "transforms"}});

// World: the run's world, z up. Formats whose convention is y up (OBJ, GLB) are turned to it.
// Input: the coordinates of the input, the same in all formats.
enum class ExportCoordinates { kWorld, kInput };
template <>
inline constexpr auto kWords<ExportCoordinates> = std::to_array<Word<ExportCoordinates>>(
    {{ExportCoordinates::kWorld, "world"}, {ExportCoordinates::kInput, "input"}});

struct ExportOptions {
  // surface.ply is written in any case: tetrec-evaluate reads it.
  std::vector<ExportFormat> formats = {ExportFormat::kPly, ExportFormat::kObj, ExportFormat::kGlb};
  ExportCoordinates coordinates = ExportCoordinates::kWorld;
  double scale = 1;  // units of the files per unit of the coordinates
  // x0, y0, z0, x1, y1, z1, d: two points in the coordinates, unscaled, and their distance in units
  // of the files. Empty: `scale` counts.
  std::vector<double> known_distance;
  // x0, y0, z0, x1, y1, z1 in the files' coordinates, z up, scaled. Empty: everything.
  std::vector<double> crop;

  void Check() const;  // throws UsageError naming the option and its value
  bool Wants(ExportFormat format) const;
  double Scale() const;
  std::optional<Bounds3> Crop() const;
};

// From the world to the frame of the files, but for the turn of those with y up.
Similarity3 ExportFromWorld(const ExportOptions& options, const Similarity3& input_from_world);

// The way back, from the frame of the files to the input's coordinates.
Similarity3 InputFromExport(const ExportOptions& options, const Similarity3& input_from_world);
// The turn of files with y up: (x, y, z) becomes (x, z, -y). In the input's coordinates nothing is
// turned.
Similarity3 YUpFromExport(const ExportOptions& options);

// Throws DataError if 32-bit floats, which files have, are too coarse for the subject because it is
// far from 0 in the coordinates of the files.
void CheckFloatsSuffice(const ExportOptions& options, const Similarity3& input_from_world,
                        const Bounds3& subject_in_world);

// Throws DataError if a format of fields is asked for and the crop contains no tet as a whole.
void CheckCropHasTets(const ExportOptions& options, const Similarity3& input_from_world,
                      const TetMesh& mesh_in_world);

// Writes the surface, which is in the frame of ExportFromWorld, and the field, which is still in
// the world, in the formats of the options, as outputs of the stage. Notes in the manifest
// "coordinates", and "input_from_surface", the way from surface.ply to the input's coordinates.
void WriteExports(const TexturedMesh& surface, const RadianceField& field_in_world,
                  const Similarity3& input_from_world, const ExportOptions& options, Stage& stage);

}  // namespace tetrec
