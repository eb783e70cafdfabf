// tetrec-import: a data set with known cameras -> a scene folder.
#include "scene/import.h"

#include "core/stage.h"

int main(int argc, char** argv) {
  tetrec::StageCommand command("import", 1,
                               "Imports a data set with known cameras into a scene folder.");
  tetrec::ImportOptions options;
  command.InputPath("DATASET", "folder of the data set");
  command.app()
      .add_option("--format", options.format, "format of the data set: nerf-synthetic")
      ->capture_default_str();
  command.app()
      .add_option("--max-size", options.max_size,
                  "bound of the pictures' longer side [pixels]; 0 keeps them as stored")
      ->capture_default_str();
  std::string background = tetrec::Name(options.background);
  command.app()
      .add_option("--background", background,
                  "what stands behind pictures with alpha: white or black")
      ->check(CLI::IsMember({"white", "black"}))
      ->capture_default_str();
  return command.Run(
      argc, argv, [&](tetrec::Stage& stage) { RunImport(options, stage); },
      [&] {
        options.background =
            background == "white" ? tetrec::Background::kWhite : tetrec::Background::kBlack;
        options.Check();
      });
}
