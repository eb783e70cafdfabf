// The course of the run in the report: curves, growth, stages, warnings and commands.
#include "core/progress.h"
#include "eval/html.h"
#include "eval/report_sections.h"
#include "eval/report_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

namespace tetrec::report {
namespace {

std::string GrowthRow(const GrowthStep& step) {
  const auto cell = [&](const std::string& text) {
    return "<td class=\"n\">" + (step.psnr > 0 ? text : std::string("–")) + "</td>";
  };
  return fmt::format("<tr><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td>",
                     Duration(step.seconds), WithThousands(step.vertices),
                     WithThousands(step.tets)) +
         fmt::format(
             "<td class=\"n\">{}</td>",
             step.empty_tets == kNotCounted || step.tets == 0
                 ? "–"
                 : fmt::format("{:.0f} %", 100.0 * double(step.empty_tets) / double(step.tets))) +
         fmt::format("<td class=\"n\">{:.0f}</td>", double(step.peak_rss_bytes) / (1 << 20)) +
         cell(fmt::format("{:.2f}", step.psnr)) + cell(fmt::format("{:+.2f}", step.gain)) +
         cell(fmt::format("{:.2f}", step.gain_standard_error)) + "<td>" + E(ReasonOf(step)) +
         "</td></tr>";
}

std::string GrowthChart(const ReportContent& content) {
  if (content.growth_svg.empty()) return "";
  return fmt::format(
      "<div class=\"plot\"><img src=\"{}\" alt=\"judged PSNR over the number of tets, with the "
      "size of the result\"></div>",
      SvgDataUri(content.growth_svg));
}

}  // namespace

std::string Convergence(const ReportContent& content) {
  std::string html = "<h2>Convergence</h2>";
  if (content.curves_svg.empty()) {
    return html + "<p class=\"note\">No curves: " + E(content.no_curves_reason) + "</p>";
  }
  const char* alts[] = {"PSNR of training batches and held-out views over seconds of optimisation",
                        "loss and number of tets over seconds of optimisation"};
  html +=
      "<p class=\"note\">The curve of held-out views is the mean over those that the run watched, "
      "which are validation views if there are any. During the run, only a sample of their pixels "
      "was rendered.</p>";
  for (size_t i = 0; i < content.curves_svg.size(); ++i) {
    html += fmt::format("<div class=\"plot\"><img src=\"{}\" alt=\"{}\"></div>",
                        SvgDataUri(content.curves_svg[i]), alts[std::min<size_t>(i, 1)]);
  }
  return html;
}

std::string Growth(const ReportContent& content) {
  if (content.growth.empty()) return "";
  std::string rows;
  for (const GrowthStep& step : content.growth) rows += GrowthRow(step);
  return "<h2>Growth of the mesh</h2><p class=\"note\">Each time that was decided about the mesh: "
         "how large it was, what the judging pictures (training pixels that are not learned) said "
         "of it and had gained since the time before, with the standard error of that gain over "
         "the views, and what was done. Rows of coarser meshes are about the mesh that was tried, "
         "and their gain is that against the best mesh before; the gain of meshes that were too "
         "fine is that over the mesh before, after as many steps. In empty tets no training ray "
         "loses 1 % of its light. The last row is the result.</p>"
         "<div class=\"scroll\"><table><thead><tr><th class=\"n\">time</th><th class=\"n\">vertices"
         "</th><th class=\"n\">tets</th><th class=\"n\">empty</th><th class=\"n\">peak MiB</th><th "
         "class=\"n\">judged dB</th>"
         "<th class=\"n\">gain dB</th><th class=\"n\">± dB</th><th>decision</th></tr></thead>"
         "<tbody>" +
         rows + "</tbody></table></div>" + GrowthChart(content);
}

std::string Stages(const RunFacts& run) {
  std::string rows;
  for (const StageFacts& stage : run.stages) {
    std::vector<std::string> counts;
    if (const auto it = stage.manifest.find("counts");
        it != stage.manifest.end() && it->is_object()) {
      for (const auto& [name, value] : it->items()) {
        if (!value.is_primitive()) continue;
        const bool whole = value.is_number_unsigned();
        const std::string text = whole               ? WithThousands(value.get<uint64_t>())
                                 : value.is_number() ? fmt::format("{:.4g}", value.get<double>())
                                 : value.is_string() ? value.get<std::string>()
                                                     : value.dump();
        std::string words = name;
        std::replace(words.begin(), words.end(), '_', ' ');
        counts.push_back(words + " " + text);
      }
    }
    rows += fmt::format(
        "<tr><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td><td "
        "class=\"note\">{}</td></tr>",
        E(stage.stage), Duration(stage.Seconds()), Bytes(stage.PeakRssBytes()),
        E(fmt::format("{}", fmt::join(counts, " · "))));
  }
  rows += fmt::format("<tr><th>Total</th><td class=\"n\">{}</td><td></td><td></td></tr>",
                      Duration(run.Seconds()));
  return "<h2>Stages</h2><div class=\"scroll\"><table><thead><tr><th>Stage</th><th "
         "class=\"n\">Time</th>"
         "<th class=\"n\">Peak memory</th><th>Counts</th></tr></thead><tbody>" +
         rows + "</tbody></table></div>";
}

std::string Warnings(const ReportContent& content) {
  std::string items;
  for (const StageFacts& stage : content.run.stages) {
    for (const std::string& warning : stage.Warnings()) {
      items += fmt::format("<li>{}: {}</li>", E(stage.stage), E(warning));
    }
  }
  for (const std::string& warning : content.warnings) items += "<li>" + E(warning) + "</li>";
  return items.empty() ? "<h2>Warnings</h2><p class=\"note\">None.</p>"
                       : "<h2>Warnings</h2><ul class=\"warnings\">" + items + "</ul>";
}

std::string Commands(const RunFacts& run) {
  std::string lines;
  for (const StageFacts& stage : run.stages) {
    const std::string command = stage.Command();
    lines += E(command.empty() ? fmt::format("# tetrec-{}: command not recorded", stage.stage)
                               : command) +
             "\n";
  }
  return "<h2>Commands</h2><p class=\"note\">As they were run. The manifest.json of each stage "
         "lists every option.</p><pre>" +
         lines + "</pre>";
}

}  // namespace tetrec::report
