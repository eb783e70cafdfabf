// The renderer's options on the command line of a stage.
#include "render/renderer_command.h"

#include <map>
#include <string>
#include <vector>

namespace tetrec {
namespace {

// An option whose words stand for values; the words are what a manifest records.
template <class Value>
CLI::Option* AddWords(CLI::App& app, const std::string& name, Value& target,
                      const std::map<std::string, Value>& values, const std::string& help) {
  std::vector<std::string> words;
  std::string standard;
  for (const auto& [word, value] : values) {
    words.push_back(word);
    if (value == target) standard = word;
  }
  return app
      .add_option_function<std::string>(
          name, [&target, values](const std::string& word) { target = values.at(word); }, help)
      ->default_str(standard)
      ->check(CLI::IsMember(words));
}

}  // namespace

void AddRendererOptions(StageCommand& command, RendererOptions& options) {
  CLI::App& app = command.app();
  AddWords<RendererKind>(app, "--renderer", options.kind,
                         {{"march", RendererKind::kMarch}, {"ppll", RendererKind::kPpll}},
                         "march (rays walk from tet to tet) or ppll (rasterised faces in per-pixel "
                         "lists, sorted)");
  command.DoesNotChangeResults(
      app.add_option_function<uint64_t>(
             "--fragment-memory",
             [&options](const uint64_t& mib) { options.fragment_memory = mib << 20; },
             "lists of fragments may take this much of the device's memory [MiB]; pictures are "
             "tiled to fit")
          ->default_str(std::to_string(options.fragment_memory >> 20))
          ->check(CLI::Range(uint64_t(1), uint64_t(1) << 24)));
  command.DoesNotChangeResults(
      AddWords<FragmentSort>(app, "--fragment-sort", options.fragment_sort,
                             {{"auto", FragmentSort::kAuto},
                              {"shell", FragmentSort::kShell},
                              {"heap", FragmentSort::kHeap}},
                             "how fragments are sorted: shell, heap, or auto (by their number)"));
  command.DoesNotChangeResults(app.add_option("--device", options.device.device,
                                              "Vulkan device: auto, cpu, gpu or a number"));
}

}  // namespace tetrec
