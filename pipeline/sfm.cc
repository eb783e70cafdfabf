// tetrec-sfm: photos -> COLMAP -> undistorted views, cameras, sparse points.
#include "scene/sfm.h"

int main(int argc, char** argv) {
  tetrec::SfmOptions options;
  tetrec::StageCommand command(
      "sfm", 3,
      "Finds the cameras of a folder of photos with COLMAP and writes the scene folder:\n"
      "undistorted pictures, cameras, sparse points, bounds of the subject and split.");
  command.InputPath("PHOTOS", "Folder of photos (.jpg, .jpeg, .png; folders inside too)");
  CLI::App& app = command.app();
  app.add_option("--max-size", options.max_size,
                 "Longer side of the scene's pictures [px], at most; never enlarged");
  app.add_option("--matcher", options.matcher,
                 "Which pairs are matched: exhaustive (all), sequential (neighbours in the order "
                 "of names), auto (all "
                 "up to 80 photos, then neighbours and what looks alike)");
  app.add_option("--max-features", options.max_features,
                 "SIFT features a picture: those of the largest scales");
  app.add_option("--camera-sharing", options.camera_sharing,
                 "Photos with the same lens parameters: auto (those of one size), single, "
                 "per-folder, per-image");
  app.add_option("--camera-model", options.camera_model,
                 "Lens model: auto (OPENCV, or SIMPLE_RADIAL for fewer than 8 photos a camera), "
                 "OPENCV, RADIAL, "
                 "SIMPLE_RADIAL, PINHOLE, SIMPLE_PINHOLE");
  app.add_option("--holdout", options.holdout,
                 "Every N-th view by name is held out for judging; 0: none");
  app.add_option("--seed", options.seed, "Seed of COLMAP's mapper");
  return command.Run(
      argc, argv, [&](tetrec::Stage& stage) { tetrec::RunSfm(options, stage); },
      [&] { tetrec::CheckSfmOptions(options); });
}
