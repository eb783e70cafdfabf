// The head of the report, and its numbers about the whole.
#include "core/progress.h"
#include "eval/report_sections.h"
#include "eval/report_text.h"
#include "eval/sizes_in_words.h"

#include <fmt/format.h>

#include <cmath>
#include <vector>

namespace tetrec::report {
namespace {

using nlohmann::json;

std::string MeanPsnr(const ReportContent& content) {
  const json& psnr = content.metrics["psnr"];
  return psnr.is_number() ? Decibel(psnr.get<double>()) : Decibel(INFINITY);
}

double OptimizeSeconds(const RunFacts& run) {
  const StageFacts* stage = run.Find("optimize");
  return stage ? stage->Seconds() : 0;
}

std::string Resolution(const std::vector<ViewScore>& views) {
  std::vector<glm::ivec2> sizes;
  for (const ViewScore& view : views) sizes.push_back({view.width, view.height});
  return SizesInWords(sizes);
}

std::string Verdict(const ReportContent& content) {
  std::string text = fmt::format("PSNR {} and SSIM {} over {} of the {} split at {}",
                                 MeanPsnr(content), NumberOr(content.metrics["ssim"], "{:.3f}"),
                                 Plural(content.scores.size(), "view"), E(content.rendered.split),
                                 Resolution(content.scores));
  const double seconds = OptimizeSeconds(content.run);
  if (seconds > 0) text += fmt::format(", after {} of optimisation", Duration(seconds));
  if (content.surface) {
    const SurfaceResult& surface = *content.surface;
    text += fmt::format("; a surface of {}", Plural(surface.facts.faces, "triangle"));
    if (surface.scores) {
      text += fmt::format(" with F-score {:.3f} at {:.3g} % of the subject's diagonal",
                          surface.scores->f_score,
                          100 * surface.scores->threshold / surface.scores->diagonal);
    }
  }
  return text + ".";
}

std::string Fact(const std::string& label, const std::string& value) {
  return value.empty() ? "" : fmt::format("<li>{} <b>{}</b></li>", E(label), E(value));
}

// `value` may end in a unit: "27.31 dB".
std::string Card(const std::string& value, const std::string& label) {
  const size_t space = value.rfind(' ');
  const std::string unit = space == std::string::npos ? "" : value.substr(space + 1);
  return fmt::format(
      "<div class=\"card\"><div class=\"value\">{} <small>{}</small></div><div class=\"label\">{}"
      "</div></div>",
      E(value.substr(0, space)), E(unit), E(label));
}

}  // namespace

std::string Header(const ReportContent& content) {
  const json& m = content.metrics;
  const StageFacts& last = content.run.stages.back();
  const json git = last.manifest.value("git", json());
  std::string facts =
      Fact("Resolution", Resolution(content.scores)) +
      Fact("Split",
           fmt::format("{} ({})", content.rendered.split, Plural(content.scores.size(), "view"))) +
      Fact("Background", content.rendered.background) +
      Fact("Rays per pixel", std::to_string(content.rendered.rays_per_pixel)) +
      Fact("Device", m["device"].is_string() ? m["device"].get<std::string>() : "unknown") +
      Fact("Seed", m["seed"].is_null() ? "" : m["seed"].dump()) +
      Fact("Revision", git.is_string() ? git.get<std::string>() : "") +
      Fact("Wall time", Duration(content.run.Seconds()));
  return fmt::format(
      "<header><p class=\"eyebrow\">Tetrec report</p><h1>{}</h1><p class=\"verdict\">{}</p>"
      "<ul class=\"facts\">{}</ul></header>",
      E(content.dataset), Verdict(content), facts);
}

std::string Cards(const ReportContent& content) {
  const json& m = content.metrics;
  std::string cards = Card(NumberOr(m["psnr"], "{:.2f} dB", "∞ dB"), "PSNR, mean over views");
  cards += Card(NumberOr(m["ssim"], "{:.3f}"), "SSIM, mean over views");
  if (content.surface && content.surface->scores) {
    cards +=
        Card(fmt::format("{:.3f}", content.surface->scores->f_score), "F-score of the surface");
  }
  cards += Card(CountOr(m["tets"]), "tets");
  cards += Card(Duration(OptimizeSeconds(content.run)), "optimisation");
  const uint64_t peak = m["peak_rss_bytes"].is_number() ? m["peak_rss_bytes"].get<uint64_t>() : 0;
  cards += Card(Bytes(peak), "peak memory");
  return "<div class=\"cards\">" + cards + "</div>";
}

std::string KeyNumbers(const ReportContent& content) {
  const json& m = content.metrics;
  std::string rows =
      Row("PSNR, mean over views", MeanPsnr(content), "RGB, 8-bit images") +
      Row("PSNR of the mean error", NumberOr(m["psnr_of_mean_mse"], "{:.2f} dB", "∞ dB"),
          "squared errors averaged over the views first");
  if (m["psnr_color_corrected"].is_number()) {
    rows += Row("PSNR of right halves", NumberOr(m["psnr_right_half"], "{:.2f} dB", "∞ dB"),
                "as rendered; for comparison with the next line") +
            Row("PSNR of right halves, colours corrected",
                NumberOr(m["psnr_color_corrected"], "{:.2f} dB"),
                "gain and offset of each channel fitted on the left half of each view");
  }
  if (m["psnr_refined_cameras"].is_number()) {
    rows += Row("PSNR with refined cameras", NumberOr(m["psnr_refined_cameras"], "{:.2f} dB"),
                "each view's pose fitted to its true image, the field as it is; whole views");
    rows += Row("PSNR of right halves, refined cameras, colours corrected",
                NumberOr(m["psnr_refined_cameras_color_corrected"], "{:.2f} dB"),
                "as above, and gain and offset fitted on the left half");
  }
  if (m["foreground_psnr"].is_number()) {
    rows += Row("PSNR of the foreground", NumberOr(m["foreground_psnr"], "{:.2f} dB"),
                "only pixels on the subject (alpha of one half or more)");
  }
  rows += Row("SSIM", NumberOr(m["ssim"], "{:.4f}"),
              "Gaussian 11×11, σ 1.5, K 0.01 and 0.03, zero padding, mean of RGB");
  if (const int masked = m.value("masked_views", 0); masked > 0) {
    rows += Row("Views with masks", std::to_string(masked),
                "scored only on the pixels that their masks select");
  }
  if (content.depth) {
    const DepthScores& depth = *content.depth;
    rows += Row(
        "Depth error, median",
        std::isfinite(depth.median) ? fmt::format("{:.2f} %", 100 * depth.median / depth.diagonal)
                                    : "infinite",
        fmt::format("of the subject's diagonal; {} pixels of {} against {}, {} of them without "
                    "a rendered surface; {:.1f} % of them within 1 %",
                    WithThousands(depth.pixels), Plural(depth.views, "view"), depth.truth,
                    WithThousands(depth.missing), 100 * depth.share_within_1_percent));
  }
  if (content.normals) {
    const NormalScores& normals = *content.normals;
    rows += Row("Angle of normals, mean", fmt::format("{:.1f}°", normals.mean_angle_deg),
                fmt::format("between normals of the rendered depth and the data set's normal maps; "
                            "{} pixels of {}; median {:.1f}°",
                            WithThousands(normals.pixels), Plural(normals.views, "view"),
                            normals.median_angle_deg));
  }
  rows += Row("LPIPS", "–", "not computed: it needs a trained network");
  rows +=
      Row("Tets / vertices", CountOr(m["tets"]) + " / " + CountOr(m["vertices"]), "of the field");
  if (m["field_bytes"].is_number()) {
    rows += Row("Field on disk", Bytes(m["field_bytes"].get<uint64_t>()), "");
  }
  return "<h2>Key numbers</h2><div class=\"scroll\"><table><thead><tr><th>Measure</th>"
         "<th class=\"n\">Value</th><th>Protocol</th></tr></thead><tbody>" +
         rows + "</tbody></table></div>";
}

}  // namespace tetrec::report
