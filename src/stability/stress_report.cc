// Writes stress.html, stress.json and stress.csv.
#include "stability/stress_report.h"

#include "core/file.h"
#include "core/progress.h"
#include "eval/csv.h"
#include "eval/html.h"
#include "stability/page.h"

#include <fmt/format.h>

#include <algorithm>

namespace tetrec {
namespace fs = std::filesystem;
using nlohmann::json;
namespace {

// A bar of the loss, at full length from 12 dB on.
std::string LossBar(const StressResult& result) {
  if (!result.lost_db) return "";
  constexpr double kFull_db = 12;
  const double share = std::clamp(*result.lost_db / kFull_db, 0.0, 1.0);
  const bool breaks = result.verdict == Verdict::kBreaks;
  return fmt::format("<span class=\"bar-of-loss\" style=\"width:{:.1f}em{}\"></span> {:+.2f}",
                     0.1 + 6 * share, breaks ? ";background:var(--breaks)" : "", -*result.lost_db);
}

std::string VerdictCell(const StressResult& result) {
  std::string cell = Name(result.verdict);
  if (result.verdict == Verdict::kBreaks) cell = "<span class=\"breaks\">" + cell + "</span>";
  if (result.verdict == Verdict::kExcused) cell += ": " + EscapeHtml(result.gone);
  return cell;
}

std::string SaidCell(const ChainResult& run) {
  std::string cell = EscapeHtml(run.said);
  if (run.exit_code != 0) {
    cell = fmt::format("exit code {} of tetrec-{}: ", run.exit_code, run.failed_stage) + cell;
  }
  return cell.empty() ? "" : "<span class=\"faint\">" + cell + "</span>";
}

std::string Row(const StressResult& result) {
  const ChainResult& run = result.run;
  return HtmlRow({EscapeHtml(result.what), VerdictCell(result), SaidCell(run), LossBar(result),
                  Decibel(run.psnr), Decibel(run.worst_psnr), WithThousands(run.tets),
                  std::to_string(run.degenerate_tets), fmt::format("{:.1f}", run.seconds)},
                 4);
}

std::string Page(const std::vector<StressResult>& results, const StressOptions& options) {
  std::string body = fmt::format(
      "<p class=\"verdict\">{}.</p><p class=\"note\">Scene: {}; {} steps unless a case says "
      "otherwise. PSNR of the held-out views, which are never damaged, 4 rays per pixel; the loss "
      "is against a run of the same kind on the scene as it was. A case holds if it loses no more "
      "than {:g} dB and has no degenerate tet.</p><div class=\"scroll\"><table>",
      StressSummary(results),
      options.scene.empty() ? "synthetic room" : EscapeHtml(options.scene.string()),
      WithThousands(options.Steps()), kLargestLoss_db);
  body += HtmlRow({"Case", "Verdict", "What the program said", "Change [dB]", "PSNR [dB]",
                   "Worst view", "Tets", "Degenerate", "Seconds"},
                  4, "th");
  for (const StressResult& result : results) body += Row(result);
  return HtmlPage("What breaks and what holds", body + "</table></div>");
}

json JsonOf(const StressResult& result) {
  json entry = JsonOf(result.run);
  entry["case"] = result.name;
  entry["what"] = result.what;
  entry["twin"] = result.twin.empty() ? json() : json(result.twin);
  entry["information_gone"] = result.gone.empty() ? json() : json(result.gone);
  entry["lost_db"] = result.lost_db ? json(*result.lost_db) : json();
  entry["verdict"] = Name(result.verdict);
  return entry;
}

std::string Csv(const std::vector<StressResult>& results) {
  std::string csv =
      "case,verdict,psnr,worst_psnr,lost_db,tets,degenerate_tets,min_radius_ratio,seconds,"
      "exit_code,failed_stage,said\n";
  const auto number = [](const std::optional<double>& value) {
    return value ? fmt::format("{:.4f}", *value) : "";
  };
  for (const StressResult& result : results) {
    const ChainResult& run = result.run;
    csv +=
        fmt::format("{},{},{},{},{},{},{},{},{},{},{},{}\n", result.name, Name(result.verdict),
                    number(run.psnr), number(run.worst_psnr), number(result.lost_db),
                    std::to_string(run.tets), std::to_string(run.degenerate_tets),
                    fmt::format("{:.3g}", run.min_radius_ratio), fmt::format("{:.2f}", run.seconds),
                    std::to_string(run.exit_code), run.failed_stage, CsvCell(run.said));
  }
  return csv;
}

}  // namespace

std::string StressSummary(const std::vector<StressResult>& results) {
  std::string summary;
  for (const auto& [verdict, word] : kWords<Verdict>) {
    const auto count = std::ranges::count(results, verdict, &StressResult::verdict);
    if (count > 0) summary += fmt::format("{}{}: {}", summary.empty() ? "" : ", ", word, count);
  }
  return summary;
}

void WriteStress(const std::vector<StressResult>& results, const StressOptions& options,
                 const fs::path& out) {
  json cases = json::array();
  for (const StressResult& result : results) cases.push_back(JsonOf(result));
  const std::string scene = options.scene.empty() ? "synthetic room" : options.scene.string();
  WriteJson(out / "stress.json", {{"schema", 1},
                                  {"scene", scene},
                                  {"iterations", options.Steps()},
                                  {"seed", options.seed},
                                  {"largest_loss_db", kLargestLoss_db},
                                  {"cases", cases}});
  WriteText(out / "stress.csv", Csv(results));
  WriteText(out / "stress.html", Page(results, options));
}

}  // namespace tetrec
