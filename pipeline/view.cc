// tetrec-view: a field to look at in a browser, also while it is being fitted.
#include "command/run_command.h"
#include "view/server.h"

int main(int argc, char** argv) {
  CLI::App app(
      "Renders the field of a run and shows it in a browser on this machine: drag to turn, wheel "
      "to\nzoom, keys to fly through the photos' cameras. Prints the address, and serves it until "
      "Ctrl-C\n(exit code 130). While tetrec-optimize is running it shows the last checkpoint.\n"
      "Example: tetrec-view RUN",
      "tetrec-view");
  app.option_defaults()->always_capture_default();
  std::filesystem::path run;
  tetrec::ViewOptions options;
  app.add_option("RUN", run,
                 "Run folder, or the folder of tetrec-optimize or tetrec-tetrahedralize")
      ->required()
      ->type_name("PATH")
      ->default_str("");
  app.add_option("--port", options.port, "Port of 127.0.0.1 to listen on; 0: any that is free");
  app.add_option("--device", options.renderer.device.device,
                 "Vulkan device: auto, cpu, gpu or a number");
  return tetrec::RunCommand(app, argc, argv, [&] {
    tetrec::CheckOptions(app, [&] { options.Check(); });
    RunViewer(options, run);
  });
}
