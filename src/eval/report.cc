// Writes report.html section by section.
#include "eval/report.h"

#include "eval/html.h"
#include "eval/report_scene.h"
#include "eval/report_sections.h"
#include "eval/report_style.h"

#include <fmt/format.h>

namespace tetrec {
namespace {

constexpr size_t kPageBytes = 14'000'000;  // views stop here

}  // namespace

std::string MakeReport(const ReportContent& content) {
  const std::string scene =
      SceneSection(content.scene, content.surface ? &content.surface->model : nullptr);
  const std::string script = (scene.empty() ? "" : SceneScript()) + kReportScript;
  // blob: is where three.js puts a surface's texture.
  const std::string head = fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; "
      "img-src data: blob:; style-src 'unsafe-inline'; script-src {}\">"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">"
      "<title>Tetrec report: {}</title><style>{}</style></head><body><main>",
      ScriptSource(script), EscapeHtml(content.dataset), kReportStyle);
  const std::string before = head + report::Header(content) + report::Cards(content) + scene +
                             report::ComparisonSection(content) + report::KeyNumbers(content) +
                             report::ViewScores(content) + report::Exposures(content) +
                             report::Cameras(content) + report::Convergence(content) +
                             report::Growth(content) + report::Surface(content);
  const std::string after =
      report::Stages(content.run) + report::Warnings(content) + report::Commands(content.run) +
      "<footer>Written by tetrec-evaluate. Colours are display sRGB throughout.</footer>"
      "</main><script>" +
      script + "</script></body></html>\n";
  const size_t others = before.size() + after.size();
  return before + report::Views(content, others < kPageBytes ? kPageBytes - others : 1) + after;
}

}  // namespace tetrec
