// The surface of a field: a level set of its opacity, or of its density, as a coloured triangle
// mesh.
#pragma once

#include "core/stage.h"
#include "core/words.h"
#include "gpu/device_options.h"
#include "surface/clean.h"
#include "surface/export.h"
#include "surface/texture.h"

#include <cstdint>

namespace tetrec {

enum class SurfaceExtent {
  kSubject,  // the subject's bounds, with a margin
  kAll,      // the whole mesh
};
template <>
inline constexpr auto kWords<SurfaceExtent> = std::to_array<Word<SurfaceExtent>>(
    {{SurfaceExtent::kSubject, "subject"}, {SurfaceExtent::kAll, "all"}});

enum class SurfaceLevel {
  kAuto,     // opacity if the scene is there and no isovalue is given, otherwise density
  kOpacity,  // where the training cameras' rays have lost part of their light (RenderSeenDepths)
  kDensity,  // a level of density (SmoothedOccupancy)
};
template <>
inline constexpr auto kWords<SurfaceLevel> =
    std::to_array<Word<SurfaceLevel>>({{SurfaceLevel::kAuto, "auto"},
                                       {SurfaceLevel::kOpacity, "opacity"},
                                       {SurfaceLevel::kDensity, "density"}});

struct SurfaceOptions {
  SurfaceLevel level = SurfaceLevel::kAuto;
  // Of the opacity: keeps what closes the surface through space that no camera sees.
  bool close = false;
  // Density of the surface [1 / world unit]; 0: a fiftieth of the typical density where a ray
  // from a camera has lost half of its light (FindHalfTransmittanceLevel).
  double isovalue = 0;
  int smoothing = 3;        // rounds of SmoothedOccupancy, for the density
  int align_rounds = 9;     // of AlignWithPhotos and FitTexture, if there are photos
  int smooth_normals = 10;  // rounds of SmoothByNormals
  SurfaceExtent extent = SurfaceExtent::kSubject;
  // Around the subject's bounds, in shares of their sides. Thin parts have few sparse points, so
  // the bounds may end before them.
  double margin = 0.15;
  CleanOptions clean;
  ExportOptions exports;
  TextureChoice texture;
  // Holes with at most this perimeter are closed, and edges are collapsed as long as no vertex ends
  // farther than this from the surface; both in % of the diagonal of the subject's bounds.
  double fill_holes = 25, max_deviation = 0.05;
  uint64_t max_faces = 0;  // simplify to this many triangles, however far they move; 0: keep all
  int rays = 10000;        // that find the isovalue
  uint64_t seed = 1;       // of those rays
  DeviceOptions device;    // that renders depths for the opacity

  void Check() const;  // throws UsageError naming the option and its value
};

// Reads the field in the stage's input "field", and for the texture the photos of its scene; writes
// the surface, and the field if asked for, by WriteExports.
void RunSurface(const SurfaceOptions& options, Stage& stage);

}  // namespace tetrec
