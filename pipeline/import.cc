// tetrec-import: a data set with known cameras, or a volume -> a scene folder.
#include "import/import.h"

#include "command/help.h"
#include "command/option_checks.h"
#include "command/stage_command.h"
#include "command/word_option.h"
#include "core/error.h"
#include "core/log.h"
#include "core/stage.h"
#include "volume/import.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

using tetrec::AddWordOption, tetrec::Background;

namespace {

constexpr const char* kVolumes = "Volumes (.raw, .nrrd, .nhdr, .mha, .mhd)";

// Options of volumes as they are typed.
struct VolumeTexts {
  std::string dimensions, spacing;
  std::vector<double> value_range;
};

void AddVolumeOptions(tetrec::StageCommand& command, tetrec::VolumeImportOptions& options,
                      VolumeTexts& texts) {
  CLI::App& app = command.app();
  command.InputPath("--transfer-function",
                    "Opacity and colour of samples: Tetrec's JSON or ParaView's", false);
  command.AlsoHash("DATASET", tetrec::FilesNamedByVolume);
  app.add_option("--dimensions", texts.dimensions,
                 ".raw: samples along x, y and z, e.g. 103x94x161; x varies fastest");
  AddWordOption(app, "--sample-type", options.sample_type, ".raw: type of a sample");
  AddWordOption(app, "--byte-order", options.byte_order, ".raw: little (the default) or big");
  app.add_option("--spacing", texts.spacing,
                 ".raw: distance of samples along x, y and z, e.g. 1x1x1.5 (default 1x1x1)");
  app.add_option("--value-range", texts.value_range,
                 "LOW,HIGH: the values of samples that become 0 and 1, to which positions of the "
                 "transfer function refer; samples outside are clamped. Default: the range of "
                 "the type of integers, or of the data for floats")
      ->delimiter(',')
      ->expected(2);
  app.add_option("--attenuation", options.attenuation,
                 "Density at opacity 1 [1 / longest side of the volume]");
  AddWordOption(
      app, "--shading", options.shading,
      "pre: interpolate density and colour between samples; post: interpolate the sample, "
      "then look up density and colour");
  app.add_option("--cameras", options.cameras, "Views on a sphere around the volume");
  app.add_option("--size", options.size_px,
                 "Width and height of the images [px]; --max-size bounds them too, if given");
  app.add_option("--rays-per-side", options.rays_per_side, "A pixel is the mean of N x N rays");
  app.add_option("--seed", options.seed, "Random seed that rotates the sphere of cameras");
  tetrec::GroupOptions(app, kVolumes,
                       {"--transfer-function", "--dimensions", "--sample-type", "--byte-order",
                        "--spacing", "--value-range", "--attenuation", "--shading", "--cameras",
                        "--size", "--rays-per-side", "--seed"});
}

void ReadTexts(const VolumeTexts& texts, tetrec::VolumeImportOptions& options) {
  if (!texts.dimensions.empty()) options.dimensions = tetrec::ParseDimensions(texts.dimensions);
  if (!texts.spacing.empty()) options.spacing = tetrec::ParseSpacing(texts.spacing);
  if (!texts.value_range.empty()) {
    options.value_range = glm::dvec2(texts.value_range[0], texts.value_range[1]);
  }
}

// --max-size bounds the views of a volume, but does not enlarge them.
void LogUnusedSize(const CLI::App& app, int max_size_px, int size_px) {
  if (app.get_option("--max-size")->count() == 0 || app.get_option("--size")->count() > 0) return;
  if (max_size_px > 0 && max_size_px <= size_px) return;
  tetrec::LogInfo("views have {} x {} pixels, fewer than --max-size allows; --size enlarges them",
                  size_px, size_px);
}

// Refuses options of volumes for image data sets, and the reverse.
void CheckOptionsFor(const CLI::App& app, bool is_volume) {
  if (is_volume) {
    tetrec::RefuseOptions(app,
                          {"--format", "--images", "--downscale", "--masks", "--test-list",
                           "--bounds", "--triangulate", "--skip-missing"},
                          "is for image data sets, not for volumes; leave it out");
    if (app.get_option("--transfer-function")->count() == 0) {
      throw tetrec::UsageError("--transfer-function is missing: a volume needs one to be rendered");
    }
    return;
  }
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_group() != kVolumes) continue;
    tetrec::RefuseOptions(
        app, {option->get_name().c_str()},
        "is for volumes, which are files .raw, .nrrd, .nhdr, .mha or .mhd; leave it out");
  }
}

}  // namespace

int main(int argc, char** argv) {
  tetrec::StageCommand command(
      "import", 11,
      "Imports a data set with known cameras, or a volume, into a scene folder.\n"
      "Example: tetrec-import DATASET -o RUN/1_scene");
  tetrec::ImportOptions options;
  tetrec::VolumeImportOptions volume_options;
  CLI::App& app = command.app();
  command.InputPath("DATASET", "Folder of the data set, or file of a volume");
  VolumeTexts volume_texts;
  AddVolumeOptions(command, volume_options, volume_texts);
  AddWordOption(
      app, "--format", options.format,
      "Format of the data set: auto (by its files), nerf-synthetic (transforms_train.json), "
      "transforms (transforms.json of instant-ngp or nerfstudio) or colmap (a model with "
      "its images)");
  app.add_option(
      "--images", options.images,
      "Folder of the images in the data set, e.g. images_4 for reduced copies, in place of a "
      "COLMAP model's (images) or of the first folder of each path in transforms.json");
  CLI::Option* max_size =
      app.add_option("--max-size", options.max_size,
                     "Largest length of the images' longer side [px]; 0 keeps them as stored")
          ->capture_default_str();
  app.add_option("--downscale", options.downscale,
                 "Factor by which the images are reduced, instead of --max-size")
      ->excludes(max_size);
  AddWordOption(app, "--background", options.background, "auto",
                "Background of the subject: white or black (for images with alpha or with a plain "
                "background), scene (photos), auto (white for images with alpha, otherwise scene)");
  AddWordOption(
      app, "--masks", options.masks,
      "Meaning of black in the data set's masks: ignore (pixels to leave out, for example "
      "people), subject (empty space around the subject: masks become alpha), none (masks "
      "are not used)");
  CLI::Option* holdout = app.add_option(
      "--holdout", options.holdout,
      "Hold out every N-th view by name for evaluation and train on the others; 0: none. "
      "Default: the data set's own split, or every 8th view if it has none");
  command.InputPath(
      "--test-list",
      "File with the names of the views to hold out, one per line; the others are for "
      "training",
      false);
  app.get_option("--test-list")->excludes(holdout);
  std::vector<double> bounds;
  app.add_option(
         "--bounds", bounds,
         "The subject's box x0,y0,z0,x1,y1,z1 in the data set's coordinates; default: found "
         "from alpha, points or cameras")
      ->delimiter(',')
      ->expected(6);
  app.add_flag("--triangulate", options.triangulate,
               "Find points by COLMAP's features and the known cameras, for data sets without "
               "points, so that the first mesh can be built from points");
  app.add_flag("--skip-missing", options.skip_missing,
               "Leave out images that the data set names but does not contain");
  using tetrec::GroupOptions;
  GroupOptions(app, "Scene", {"--max-size", "--background", "--holdout", "--test-list"});
  GroupOptions(app, "Image data sets",
               {"--format", "--images", "--downscale", "--masks", "--bounds", "--triangulate",
                "--skip-missing"});
  bool is_volume = false;
  return command.Run(
      argc, argv,
      [&](tetrec::Stage& stage) {
        if (is_volume) {
          LogUnusedSize(app, options.max_size, volume_options.size_px);
          return RunVolumeImport(volume_options, stage);
        }
        RunImport(options, stage);
      },
      [&] {
        if (!bounds.empty()) {
          options.bounds_in_input = {{bounds[0], bounds[1], bounds[2]},
                                     {bounds[3], bounds[4], bounds[5]}};
        }
        options.Check();
        const std::string dataset = app.get_option("DATASET")->as<std::string>();
        is_volume = tetrec::IsVolumeFile(dataset);
        CheckOptionsFor(app, is_volume);
        if (!is_volume) return;
        ReadTexts(volume_texts, volume_options);
        volume_options.background = options.background.value_or(Background::kWhite);
        volume_options.holdout = options.holdout.value_or(volume_options.holdout);
        if (app.get_option("--max-size")->count() > 0 && options.max_size > 0) {
          volume_options.size_px = std::min(volume_options.size_px, options.max_size);
        }
        volume_options.Check();
        volume_options.CheckFor(dataset);
      });
}
