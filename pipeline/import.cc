// tetrec-import: a data set with known cameras -> a scene folder.
#include "scene/import.h"

#include "core/stage.h"

#include <map>

using tetrec::Background, tetrec::DatasetFormat;

int main(int argc, char** argv) {
  tetrec::StageCommand command("import", 3,
                               "Imports a data set with known cameras into a scene folder.");
  tetrec::ImportOptions options;
  CLI::App& app = command.app();
  command.InputPath("DATASET", "folder of the data set");
  const std::map<std::string, DatasetFormat> formats = {
      {Name(DatasetFormat::kAuto), DatasetFormat::kAuto},
      {Name(DatasetFormat::kNerfSynthetic), DatasetFormat::kNerfSynthetic},
      {Name(DatasetFormat::kTransforms), DatasetFormat::kTransforms},
      {Name(DatasetFormat::kColmap), DatasetFormat::kColmap}};
  std::string format = Name(options.format);
  app.add_option("--format", format,
                 "format of the data set: auto (by the files that are there), nerf-synthetic "
                 "(transforms_train.json), transforms (transforms.json of instant-ngp or "
                 "nerfstudio) or colmap (a model with its pictures)")
      ->check(CLI::IsMember(formats))
      ->capture_default_str();
  app.add_option("--images", options.images,
                 "folder of a COLMAP model's pictures in the data set, e.g. images_4 of the same "
                 "pictures made smaller; without it: images");
  app.add_option("--max-size", options.max_size,
                 "bound of the pictures' longer side [pixels]; 0 keeps them as stored")
      ->capture_default_str();
  const std::map<std::string, std::optional<Background>> backgrounds = {
      {"auto", std::nullopt},
      {Name(Background::kWhite), Background::kWhite},
      {Name(Background::kBlack), Background::kBlack},
      {Name(Background::kScene), Background::kScene}};
  std::string background = "auto";
  app.add_option("--background", background,
                 "what stands behind the subject: white or black (pictures with alpha, or taken "
                 "before it), scene (photos), auto (white behind alpha, else scene)")
      ->check(CLI::IsMember(backgrounds))
      ->capture_default_str();
  app.add_option("--holdout", options.holdout,
                 "of data sets without a split of their own, every N-th view by name is held out "
                 "for judging; 0: none")
      ->capture_default_str();
  app.add_flag("--triangulate", options.triangulate,
               "find points by COLMAP's features and the known cameras, for data sets without "
               "points, so that the first mesh can be made of points");
  return command.Run(
      argc, argv, [&](tetrec::Stage& stage) { RunImport(options, stage); },
      [&] {
        options.format = formats.at(format);
        options.background = backgrounds.at(background);
        options.Check();
      });
}
