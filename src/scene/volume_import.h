// A scientific volume and a transfer function into a scene folder: pictures from a sphere of
// cameras, and the volume's own samples as ground truth for the field.
//
// The input's frame is the volume's own (its spacings and origin). Beside the scene's files the
// folder holds ground_truth/volume.nrrd: four floats a sample, density [1 / world unit] and display
// sRGB, its space the scene's world. At the samples both shadings agree; between them the field of
// a pre-shaded volume is linear in each axis.
#pragma once

#include "core/free_memory.h"
#include "core/stage.h"
#include "scene/scene.h"
#include "scene/volume_io.h"
#include "scene/volume_rays.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace tetrec {

struct VolumeImportOptions {
  // Of .raw files only, as on the command line: "103x94x161", "uint8", "little", "1x1x1".
  std::string dimensions, sample_type, byte_order, spacing;
  // The values that become 0 and 1; empty: the type's range, of float the data's own.
  std::vector<double> value_range;
  double attenuation = 50;  // density at opacity 1 [1 / the volume's longest side]
  Shading shading = Shading::kPre;
  int cameras = 800;
  int size_px = 256;
  int rays_per_side = 1;
  int holdout = 8;  // of so many views one is for test and one for validation; 0: all train
  uint64_t seed = 0;
  Background background = Background::kWhite;

  void Check() const;  // throws UsageError naming the option and its value
  // Throws UsageError where a .raw file has no layout, or another file is given one.
  void CheckFor(const std::filesystem::path& volume) const;
  VolumeLayout Layout() const;
  ValueRange Range() const;
};

// Throws EnvironmentError where the samples and their shaded form do not fit.
void CheckVolumeMemory(const VolumeLayout& layout, const std::string& name, const FreeMemory& free);

// Cameras on a sphere around the centre of the world, which look at it and see the ball of
// `radius`: a Fibonacci lattice turned by a random rotation. Adds one camera and the views.
void AddSphereOfViews(const VolumeImportOptions& options, double radius, Scene& scene);

struct ImportedVolume {
  Scene scene;
  VolumeFile file;
  size_t dense_samples = 0;  // with opacity above 0
};

// Writes pictures last: what there is too little memory or space for, and a transfer function that
// leaves nothing visible (DataError), show before.
ImportedVolume ImportVolume(const std::filesystem::path& volume,
                            const std::filesystem::path& transfer_function,
                            const std::filesystem::path& folder, const VolumeImportOptions& options,
                            const FreeMemory& free = MeasureFreeHostMemory());

// The stage: inputs "DATASET" and "transfer-function".
void RunVolumeImport(const VolumeImportOptions& options, Stage& stage);

}  // namespace tetrec
