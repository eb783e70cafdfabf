// tetrec-import: a data set with known cameras, or a volume -> a scene folder.
#include "scene/import.h"

#include "core/error.h"
#include "core/stage.h"
#include "core/word_option.h"
#include "scene/volume_import.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

using tetrec::AddWordOption, tetrec::Background;

namespace {

constexpr const char* kVolumes = "Volumes (.raw, .nrrd, .nhdr, .mha, .mhd)";

void AddVolumeOptions(tetrec::StageCommand& command, tetrec::VolumeImportOptions& options) {
  CLI::App& app = command.app();
  command.InputPath("--transfer-function", "opacity and colour of samples: our JSON or ParaView's",
                    false);
  command.FilesNamedBy("DATASET", tetrec::FilesNamedByVolume);
  app.add_option("--dimensions", options.dimensions,
                 ".raw: samples along x, y and z, like 103x94x161; x is fastest");
  app.add_option("--sample-type", options.sample_type, ".raw: uint8, uint16, int16 or float32");
  app.add_option("--byte-order", options.byte_order, ".raw: little (the default) or big");
  app.add_option("--spacing", options.spacing,
                 ".raw: distance of samples along x, y and z, like 1x1x1.5 (the default is 1x1x1)");
  app.add_option("--value-range", options.value_range,
                 "LOW,HIGH: the values of samples that become 0 and 1, to which positions of the "
                 "transfer function refer; samples outside are clamped. Default: the range of "
                 "integers' type, of float samples the data's own")
      ->delimiter(',')
      ->expected(2);
  app.add_option("--attenuation", options.attenuation,
                 "density at opacity 1 [1 / the volume's longest side]");
  AddWordOption(app, "--shading", options.shading,
                "pre: density and colour are interpolated between samples; post: the sample is "
                "interpolated, then given density and colour");
  app.add_option("--cameras", options.cameras, "views, on a sphere around the volume");
  app.add_option(
      "--size", options.size_px,
      "width and height of the pictures [pixels]; --max-size bounds them too, where it is given");
  app.add_option("--rays-per-side", options.rays_per_side,
                 "a pixel is the mean of so many times so many rays");
  app.add_option("--seed", options.seed, "turns the sphere of cameras");
  for (const char* name : {"--transfer-function", "--dimensions", "--sample-type", "--byte-order",
                           "--spacing", "--value-range", "--attenuation", "--shading", "--cameras",
                           "--size", "--rays-per-side", "--seed"}) {
    app.get_option(name)->group(kVolumes);
  }
}

// Options of volumes are for volumes, and those of pictures for pictures.
void CheckOptionsFor(const CLI::App& app, bool is_volume) {
  const auto refuse = [](const CLI::Option* option, const char* what) {
    if (option->count() == 0) return;
    throw tetrec::UsageError(fmt::format("{}: is for {}", option->get_name(), what));
  };
  if (is_volume) {
    for (const char* name : {"--format", "--images", "--downscale", "--masks", "--test-list",
                             "--bounds", "--triangulate", "--skip-missing"}) {
      refuse(app.get_option(name), "pictures, not for volumes");
    }
    if (app.get_option("--transfer-function")->count() == 0) {
      throw tetrec::UsageError(
          "--transfer-function is missing: a volume needs one to become pictures");
    }
    return;
  }
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_group() == kVolumes) {
      refuse(option, "volumes, which are files .raw, .nrrd, .nhdr, .mha or .mhd");
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  tetrec::StageCommand command("import", 5,
                               "Imports a data set with known cameras, or a volume, into a scene "
                               "folder.");
  tetrec::ImportOptions options;
  tetrec::VolumeImportOptions volume_options;
  CLI::App& app = command.app();
  command.InputPath("DATASET", "folder of the data set, or file of a volume");
  AddVolumeOptions(command, volume_options);
  AddWordOption(app, "--format", options.format,
                "format of the data set: auto (by the files that are there), nerf-synthetic "
                "(transforms_train.json), transforms (transforms.json of instant-ngp or "
                "nerfstudio) or colmap (a model with its pictures)");
  app.add_option("--images", options.images,
                 "folder of a COLMAP model's pictures in the data set, e.g. images_4 of the same "
                 "pictures made smaller; without it: images");
  CLI::Option* max_size =
      app.add_option("--max-size", options.max_size,
                     "bound of the pictures' longer side [pixels]; 0 keeps them as stored")
          ->capture_default_str();
  app.add_option("--downscale", options.downscale,
                 "divides the pictures' sides by this factor, in place of --max-size")
      ->excludes(max_size);
  AddWordOption(app, "--background", options.background, "auto",
                "what stands behind the subject: white or black (pictures with alpha, or taken "
                "before it), scene (photos), auto (white behind alpha, else scene)");
  AddWordOption(app, "--masks", options.masks,
                "what is black in the data set's masks: ignore (something that is not to be "
                "modelled, people for example: those pixels count for nothing), subject (empty "
                "space around the subject: masks become alpha), none (masks are not used)");
  CLI::Option* holdout =
      app.add_option("--holdout", options.holdout,
                     "every N-th view by name is held out for judging, the others train; 0: none. "
                     "Default: the data set's own split; every 8th of those that have none");
  command.InputPath("--test-list",
                    "file with the names of the views that are held out, one a line; the others "
                    "train",
                    false);
  app.get_option("--test-list")->excludes(holdout);
  std::vector<double> bounds;
  app.add_option("--bounds", bounds,
                 "the subject's box x0,y0,z0,x1,y1,z1 in the data set's coordinates, in place of "
                 "what alpha, points or cameras tell")
      ->delimiter(',')
      ->expected(6);
  app.add_flag("--triangulate", options.triangulate,
               "find points by COLMAP's features and the known cameras, for data sets without "
               "points, so that the first mesh can be made of points");
  app.add_flag("--skip-missing", options.skip_missing,
               "leave out pictures that the data set names and that are not there");
  bool is_volume = false;
  return command.Run(
      argc, argv,
      [&](tetrec::Stage& stage) {
        if (is_volume) return RunVolumeImport(volume_options, stage);
        RunImport(options, stage);
      },
      [&] {
        if (!bounds.empty()) {
          options.subject_in_input = {{bounds[0], bounds[1], bounds[2]},
                                      {bounds[3], bounds[4], bounds[5]}};
        }
        options.Check();
        const std::string dataset = app.get_option("DATASET")->as<std::string>();
        is_volume = tetrec::IsVolumeFile(dataset);
        CheckOptionsFor(app, is_volume);
        if (!is_volume) return;
        volume_options.background = options.background.value_or(Background::kWhite);
        volume_options.holdout = options.holdout.value_or(volume_options.holdout);
        if (app.get_option("--max-size")->count() > 0 && options.max_size > 0) {
          volume_options.size_px = std::min(volume_options.size_px, options.max_size);
        }
        volume_options.Check();
        volume_options.CheckFor(dataset);
      });
}
