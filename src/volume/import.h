// Imports a scientific volume and a transfer function as a scene folder: images from a sphere of
// cameras, and the volume's own samples as ground truth for the field.
//
// The input's frame is the volume's own (its spacings and origin). Besides the scene's files the
// folder contains ground_truth/volume.nrrd with four floats per sample, density [1 / world unit]
// and display sRGB, in the scene's world. Both shadings agree at the samples; between them the
// field of a pre-shaded volume is linear along each axis.
#pragma once

#include "core/free_memory.h"
#include "core/stage.h"
#include "scene/scene.h"
#include "scene/split.h"
#include "volume/ray_integrator.h"
#include "volume/reader.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace tetrec {

enum class ByteOrder { kLittle, kBig };
template <>
inline constexpr auto kWords<ByteOrder> =
    std::to_array<Word<ByteOrder>>({{ByteOrder::kLittle, "little"}, {ByteOrder::kBig, "big"}});

struct VolumeImportOptions {
  // The layout of .raw files; the headers of all other files specify it.
  std::optional<glm::ivec3> dimensions;  // samples along x, y and z
  std::optional<SampleType> sample_type;
  std::optional<ByteOrder> byte_order;  // unset: little
  std::optional<glm::dvec3> spacing;    // between samples, in the file's own units; unset: 1
  ValueRange value_range;               // of all files
  double attenuation = 50;              // density at opacity 1 [1 / the volume's longest side]
  Shading shading = Shading::kPre;
  int cameras = 800;      // one view each, on a sphere around the volume
  int size_px = 256;      // width and height of the images
  int rays_per_side = 1;  // squared: rays averaged in a pixel, on a regular grid
  // Of this many views one is for test and one for validation; 0: all views train.
  int holdout = kUsualHoldout;
  uint64_t seed = 0;  // turns the sphere of cameras
  Background background = Background::kWhite;

  void Check() const;  // throws UsageError, which starts with the option's name
  // Throws UsageError if a .raw file has no layout, or any other file is given one.
  void CheckFor(const std::filesystem::path& volume) const;
  VolumeLayout Layout() const;  // of a .raw file; throws UsageError
};

// From text like "103x94x161" or "1x1x1.5". Throw UsageError.
glm::ivec3 ParseDimensions(const std::string& text);
glm::dvec3 ParseSpacing(const std::string& text);

// Throws EnvironmentError if the samples and their shaded form do not fit into memory.
void CheckVolumeMemory(const VolumeLayout& layout, const std::string& name, const FreeMemory& free);

// Adds one camera and the views: places on a sphere around the centre of the world (a Fibonacci
// lattice turned by a random rotation) that look at the centre and see the ball of `radius`.
void AddSphereOfViews(const VolumeImportOptions& options, double radius, Scene& scene);

struct ImportedVolume {
  Scene scene;
  std::unique_ptr<const VolumeFile> file;
  RayIntegrator rays;  // refers to the file's volume
};

// Throws EnvironmentError if there is too little memory, and DataError for damaged files and a
// transfer function that leaves nothing visible.
ImportedVolume ReadVolumeForImport(const std::filesystem::path& volume,
                                   const std::filesystem::path& transfer_function,
                                   const VolumeImportOptions& options,
                                   const FreeMemory& free = MeasureFreeHostMemory());

// Writes the scene, its images (each pixel the mean of `rays_per_side` squared rays) and the ground
// truth; the ground truth first, as it may need the most space.
void WriteImportedVolume(const ImportedVolume& imported, int rays_per_side,
                         const std::filesystem::path& folder);

// The stage; its inputs are "DATASET" and "transfer-function".
void RunVolumeImport(const VolumeImportOptions& options, Stage& stage);

}  // namespace tetrec
