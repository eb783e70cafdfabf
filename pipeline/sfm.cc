// tetrec-sfm: photos -> COLMAP -> undistorted views, cameras, sparse points.
#include "sfm/sfm.h"

#include "command/help.h"
#include "command/stage_command.h"
#include "command/word_option.h"
#include "core/error.h"
#include "core/stage.h"
#include "import/dataset.h"

#include <fmt/format.h>

#include <filesystem>
#include <vector>

namespace {

// COLMAP would search for them in vain among all pictures of the data set.
void RefuseKnownCameras(const std::string& folder) {
  const std::vector<tetrec::DatasetFormat> formats = tetrec::FormatsOf(folder);
  if (formats.empty()) return;
  throw tetrec::DataError(
      fmt::format("{}: a data set whose cameras are known ({}); give it to tetrec-import, or give "
                  "the folder of its photos alone",
                  folder, Name(formats[0])));
}

// Masks of a video's frames could not be named like them.
void CheckMasks(const std::filesystem::path& masks, const std::filesystem::path& photos) {
  std::error_code missing;
  if (std::filesystem::is_regular_file(photos, missing)) {
    throw tetrec::UsageError(fmt::format(
        "--masks is {}, but PHOTOS is a video; give its frames and their masks as folders",
        masks.string()));
  }
  if (std::filesystem::equivalent(masks, photos, missing)) {
    throw tetrec::UsageError(fmt::format(
        "--masks is {}, the folder of the photos; put the masks into a folder of their own",
        masks.string()));
  }
}

}  // namespace

int main(int argc, char** argv) {
  tetrec::SfmOptions options;
  tetrec::StageCommand command(
      "sfm", 14,
      "Finds the cameras of a folder of photos with COLMAP and writes the scene folder:\n"
      "undistorted images, cameras, sparse points, the bounds of the subject and the split.\n"
      "Example: tetrec-sfm PHOTOS -o RUN/1_scene");
  command.InputPath(
      "PHOTOS", "Folder of photos (.jpg, .png, .tif, .heic), including its subfolders, or a video");
  command.InputPath("--masks",
                    "Folder of masks, one for each photo and named like it (a.png or a.jpg.png for "
                    "a.jpg): what is black has no features and is neither trained on nor scored",
                    false);
  CLI::App& app = command.app();
  app.add_option(
      "--max-size", options.max_size,
      "Largest length of the longer side of the scene's images [px]; photos are never enlarged");
  app.add_option("--frames", options.frames,
                 "Frames of a video to use, at most: the sharpest ones, evenly spaced by motion");
  tetrec::AddWordOption(
      app, "--matcher", options.matcher,
      "Pairs of photos to match: exhaustive (all), sequential (neighbours in the order of names), "
      "auto (all for up to 80 photos, otherwise neighbours and similar photos)");
  app.add_option("--max-features", options.max_features,
                 "SIFT features per photo, those of the largest scales");
  app.add_option("--retries", options.retries,
                 "Further tries where photos stay unregistered, each with 8/3 of the features for "
                 "these photos and those that overlap them, and one with milder demands if too few "
                 "are registered still; 0: none");
  tetrec::AddWordOption(
      app, "--camera-sharing", options.camera_sharing,
      "Photos that share lens parameters: auto (those of the same size whose EXIF notes the same "
      "camera, focal length and digital zoom), single (all), per-folder, per-image (none)");
  tetrec::AddWordOption(
      app, "--camera-model", options.camera_model,
      "Lens model: auto (for each camera OPENCV, or SIMPLE_RADIAL if it took fewer than 8 photos; "
      "a simpler model for all if one folds over inside the photos, if its pixels are oblong and "
      "square ones fit as well, or if it registers too few photos), OPENCV, RADIAL, SIMPLE_RADIAL, "
      "PINHOLE, SIMPLE_PINHOLE");
  std::vector<double> bounds;
  app.add_option("--bounds", bounds,
                 "The subject's box x0,y0,z0,x1,y1,z1, in the coordinates of the points.ply that "
                 "is written without this option; default: found from points and cameras")
      ->delimiter(',')
      ->expected(6);
  app.add_option("--holdout", options.holdout,
                 "Hold out every N-th view by name for evaluation; 0: none");
  app.add_option("--train-every", options.train_every,
                 "Train on every N-th photo by name, starting with the second, and leave those out "
                 "of the scene that are neither trained on nor held out; 1: train on all. All "
                 "photos help to find the cameras");
  app.add_option("--max-unreadable", options.max_unreadable,
                 "Share of the photos that may be unreadable (damaged, or of another format) and "
                 "are left out with a warning; with more of them, or 0 and any, the stage fails");
  app.add_option("--seed", options.seed, "Random seed of COLMAP's mapper");
  using tetrec::GroupOptions;
  GroupOptions(app, "Scene",
               {"--masks", "--max-unreadable", "--frames", "--max-size", "--bounds", "--holdout",
                "--train-every"});
  GroupOptions(
      app, "COLMAP",
      {"--matcher", "--max-features", "--retries", "--camera-sharing", "--camera-model", "--seed"});
  return command.Run(
      argc, argv, [&](tetrec::Stage& stage) { tetrec::RunSfm(options, stage); },
      [&] {
        if (!bounds.empty()) {
          options.bounds_in_found_world = {{bounds[0], bounds[1], bounds[2]},
                                           {bounds[3], bounds[4], bounds[5]}};
        }
        options.Check();
        const std::filesystem::path photos = app.get_option("PHOTOS")->as<std::string>();
        if (app.count("--frames") > 0 && std::filesystem::is_directory(photos)) {
          throw tetrec::UsageError("--frames chooses frames of a video, but PHOTOS is a folder");
        }
        if (app.count("--masks") > 0) {
          CheckMasks(app.get_option("--masks")->as<std::string>(), photos);
        }
        RefuseKnownCameras(photos);
      });
}
