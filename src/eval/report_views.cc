// The views of the report: their pictures and their scores.
#include "eval/find_view.h"
#include "eval/html.h"
#include "eval/image_metrics.h"
#include "eval/report_sections.h"
#include "eval/report_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <optional>
#include <vector>

namespace tetrec::report {
namespace {

constexpr size_t kMostViewRows = 1000;
constexpr int kLargePicture_px = 512, kSlider_px = 400, kThumbnail_px = 160;
constexpr int kLargeQuality = 90, kThumbnailQuality = 80;

// The rendered depth of a view in colours, and its normals if the camera is known.
struct DepthPictures {
  std::optional<Image> depth, normals;
};

DepthPictures DrawDepth(const ReportContent& content, size_t index) {
  const RenderedView& view = content.rendered.views[index];
  if (!view.depth) return {};
  const DepthMap map = ReadDepthMap(*view.depth);
  DepthPictures pictures{ColoredDepth(map, RangeOf(map)), {}};
  const View* seen = content.scene ? FindView(*content.scene, view.name) : nullptr;
  if (seen != nullptr) {
    pictures.normals = NormalPicture(map, content.scene->cameras[size_t(seen->camera)]);
  }
  return pictures;
}

std::string Trio(const ReportContent& content, size_t index, const std::string& rank) {
  const RenderedView& view = content.rendered.views[index];
  const ViewScore& score = content.scores[index];
  const Image truth = ReadImage(view.truth), render = ReadImage(view.render);
  const Image judged = view.seen ? PaintedOver(render, truth, ReadImage(*view.seen)) : render;
  const auto figure = [&](const Image& image, const std::string& what) {
    return fmt::format(
        "<figure>{}<figcaption>{}</figcaption></figure>",
        Picture(FitInto(image, kLargePicture_px), kLargeQuality, what + " of view " + view.name),
        E(what));
  };
  std::string figures = figure(truth, "ground truth") + figure(render, "render") +
                        figure(ErrorMap(judged, truth), "error ×4");
  const DepthPictures pictures = DrawDepth(content, index);
  if (pictures.depth) figures += figure(*pictures.depth, "depth");
  if (pictures.normals) figures += figure(*pictures.normals, "normals");
  return fmt::format("<h3>{}: {} · {} · SSIM {:.3f}</h3><div class=\"trio\">{}</div>", rank,
                     E(view.name), Decibel(score.psnr), score.ssim, figures);
}

std::string OptionalDecibel(const std::optional<double>& psnr) {
  return psnr ? Decibel(*psnr) : "–";
}

std::string ViewScoreRow(const ViewScore& score, bool has_refined) {
  std::string cells = fmt::format(
      "<td>{}</td><td class=\"n\">{}</td><td class=\"n\">{:.3f}</td><td class=\"n\">{}</td>"
      "<td class=\"n\">{}</td>",
      E(score.name), Decibel(score.psnr), score.ssim, OptionalDecibel(score.right_half_psnr),
      OptionalDecibel(score.corrected_psnr));
  if (has_refined) {
    cells += fmt::format(
        "<td class=\"n\">{}</td><td class=\"n\">{}</td>", OptionalDecibel(score.refined_psnr),
        score.refined_shift_px ? fmt::format("{:.2f} px", *score.refined_shift_px) : "–");
  }
  return "<tr>" + cells + "</tr>";
}

// The true image and the rendering, one over the other, and a slider that moves the line between
// them.
std::string Slider(const RenderedView& view) {
  const auto picture = [&](const std::filesystem::path& file, const char* what) {
    return Picture(FitInto(ReadImage(file), kSlider_px), kThumbnailQuality,
                   std::string(what) + " of view " + view.name);
  };
  return fmt::format(
      "<div class=\"compare\">{}<div class=\"over\">{}</div></div>"
      "<input class=\"slider\" type=\"range\" min=\"0\" max=\"100\" value=\"50\" "
      "aria-label=\"line between ground truth, on the left, and render of view {}\">",
      picture(view.truth, "ground truth"), picture(view.render, "render"), E(view.name));
}

}  // namespace

std::string ComparisonSection(const ReportContent& content) {
  std::vector<size_t> order(content.scores.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    return content.scores[a].psnr > content.scores[b].psnr;
  });
  std::string html = "<h2>Ground truth, render, error</h2>";
  html += fmt::format(
      "<div class=\"bar\"><span>0</span>{}<span>{:.0f}/255 and more</span></div>"
      "<p class=\"note\">Error: mean absolute difference of red, green and blue, times {:.0f}. "
      "Depth: where a ray has lost half of its light, from bright (near) to dark (far), grey where "
      "it "
      "never does. Normals of that depth: red to the right, green up, blue to the camera.</p>",
      Picture(ErrorMapColorBar(256, 12), 95,
              "colour scale of the error, from dark (none) to bright"),
      255 / kErrorMapGain, kErrorMapGain);
  html += Trio(content, order.front(), "Best");
  if (order.size() > 2) html += Trio(content, order[order.size() / 2], "Median");
  if (order.size() > 1) html += Trio(content, order.back(), "Worst");
  return html;
}

std::string ViewScores(const ReportContent& content) {
  const bool has_refined =
      std::any_of(content.scores.begin(), content.scores.end(),
                  [](const ViewScore& score) { return score.refined_psnr.has_value(); });
  std::string rows;
  const size_t shown = std::min(content.scores.size(), kMostViewRows);
  for (size_t i = 0; i < shown; ++i) rows += ViewScoreRow(content.scores[i], has_refined);
  return "<h2>Scores of the views</h2><p class=\"note\">PSNR and SSIM judge whole views as they "
         "are rendered. The columns of the right half judge that half only: as it is rendered, "
         "and with the exposure and white balance that were fitted on the left half." +
         std::string(has_refined
                         ? " With refined cameras: the whole view again, from a camera whose pose "
                           "was fitted to the true image, and how far that moved the picture."
                         : "") +
         (shown < content.scores.size()
              ? fmt::format(" The first {} of {} views are listed; metrics.json has all.", shown,
                            content.scores.size())
              : std::string()) +
         "</p>"
         "<div class=\"scroll\"><table><thead><tr><th>View</th><th class=\"n\">PSNR</th>"
         "<th class=\"n\">SSIM</th><th class=\"n\">Right half</th>"
         "<th class=\"n\">Right half, corrected</th>" +
         (has_refined ? "<th class=\"n\">With refined cameras</th><th class=\"n\">moved</th>"
                      : "") +
         "</tr></thead><tbody>" + rows + "</tbody></table></div>";
}

std::string Views(const ReportContent& content, size_t most_bytes) {
  std::string html;
  size_t shown = 0;
  for (; shown < content.scores.size() && html.size() < most_bytes; ++shown) {
    const RenderedView& view = content.rendered.views[shown];
    const ViewScore& score = content.scores[shown];
    const auto thumbnail = [&](const Image& image, const char* what) {
      return Picture(FitInto(image, kThumbnail_px), kThumbnailQuality,
                     std::string(what) + " of view " + view.name);
    };
    const DepthPictures pictures = DrawDepth(content, shown);
    std::string images;
    if (pictures.depth) images += thumbnail(*pictures.depth, "depth");
    if (pictures.normals) images += thumbnail(*pictures.normals, "normals");
    html += fmt::format(
        "<figure class=\"view\">{}<div class=\"pair\">{}</div><figcaption>{}<br>{} · SSIM "
        "{:.3f}{}</figcaption></figure>",
        Slider(view), images, E(view.name), Decibel(score.psnr), score.ssim,
        score.foreground_psnr ? " · subject " + Decibel(*score.foreground_psnr) : "");
  }
  std::string heading =
      "<h2>All views</h2><p class=\"note\">Ground truth to the left of the line, render to the "
      "right; the slider (or the arrow keys) moves the line. Below it depth and normals.";
  if (shown < content.scores.size()) {
    heading +=
        fmt::format(" The first {} of {} views are shown; metrics.json has the scores of all.",
                    shown, content.scores.size());
  }
  return heading + "</p><div class=\"thumbs\">" + html + "</div>";
}

}  // namespace tetrec::report
