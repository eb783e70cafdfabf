// Writes report.html section by section.
#include "eval/report.h"

#include "core/progress.h"
#include "eval/find_view.h"
#include "eval/html.h"
#include "eval/image_metrics.h"
#include "eval/report_scene.h"
#include "eval/report_style.h"
#include "eval/sizes_in_words.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace tetrec {
namespace {

using nlohmann::json;

constexpr size_t kPageBytes = 14'000'000;  // views stop here; the last one may need some more
constexpr size_t kMostViewRows = 1000, kMostExposureRows = 100, kMostCameraRows = 100;
constexpr double kNeutralDeviation = 0.01;  // of log gain and of offset
constexpr int kLargePicture_px = 512, kSlider_px = 400, kThumbnail_px = 160;
constexpr int kLargeQuality = 90, kThumbnailQuality = 80;

std::string E(const std::string& text) { return EscapeHtml(text); }

std::string Picture(const Image& image, int quality, const std::string& alt) {
  return fmt::format("<img src=\"{}\" width=\"{}\" height=\"{}\" alt=\"{}\">",
                     JpegDataUri(image, quality), image.width, image.height, E(alt));
}

std::string Decibel(double psnr) {
  return std::isfinite(psnr) ? fmt::format("{:.2f} dB", psnr) : "identical (∞ dB)";
}

// A number of metrics.json as text; a dash if it is null.
std::string NumberOr(const json& value, const char* format, const char* otherwise = "–") {
  return value.is_number() ? fmt::format(fmt::runtime(format), value.get<double>()) : otherwise;
}

std::string CountOr(const json& value) {
  return value.is_number_unsigned() || (value.is_number_integer() && value.get<int64_t>() >= 0)
             ? WithThousands(value.get<uint64_t>())
             : "–";
}

std::string Bytes(uint64_t bytes) {
  if (bytes == 0) return "–";
  constexpr double kMiB = 1 << 20;
  if (bytes < (uint64_t{1} << 20)) return fmt::format("{:.1f} KiB", double(bytes) / 1024);
  return bytes < (uint64_t{1} << 30) ? fmt::format("{:.1f} MiB", double(bytes) / kMiB)
                                     : fmt::format("{:.2f} GiB", double(bytes) / kMiB / 1024);
}

// "4.2 s", "4:58 min", "1:02:03 h"
std::string Duration(double seconds) {
  if (seconds < 9.5) return fmt::format("{:.1f} s", seconds);
  return AsDuration(seconds) + (seconds + 0.5 >= 3600 ? " h" : " min");
}

// "1 view", "5 views"
std::string Plural(size_t count, const std::string& noun) {
  return fmt::format("{} {}{}", WithThousands(count), noun, count == 1 ? "" : "s");
}

std::string MeanPsnr(const ReportContent& content) {
  const json& psnr = content.metrics["psnr"];
  return psnr.is_number() ? Decibel(psnr.get<double>()) : Decibel(INFINITY);
}

double OptimizeSeconds(const RunFacts& run) {
  const StageFacts* stage = run.Find("optimize");
  return stage ? stage->Seconds() : 0;
}

double TotalSeconds(const RunFacts& run) {
  double seconds = 0;
  for (const StageFacts& stage : run.stages) seconds += stage.Seconds();
  return seconds;
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
      Fact("Wall time", Duration(TotalSeconds(content.run)));
  return fmt::format(
      "<header><p class=\"eyebrow\">Tetrec report</p><h1>{}</h1><p class=\"verdict\">{}</p>"
      "<ul class=\"facts\">{}</ul></header>",
      E(content.dataset), Verdict(content), facts);
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

std::string Row(const std::string& name, const std::string& value, const std::string& protocol) {
  return fmt::format("<tr><td>{}</td><td class=\"n\">{}</td><td>{}</td></tr>", E(name), E(value),
                     E(protocol));
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

// How far the photo is from the mean exposure.
double DeviationOf(const PhotoExposure& exposure) {
  double deviation = 0;
  for (int c = 0; c < 3; ++c) {
    deviation =
        std::max({deviation, std::abs(std::log(exposure.gain[c])), std::abs(exposure.offset[c])});
  }
  return deviation;
}

std::string ExposureRow(const PhotoExposure& exposure) {
  std::string cells;
  for (int c = 0; c < 3; ++c) {
    cells += fmt::format("<td class=\"n\">{:.3f}</td>", exposure.gain[c]);
  }
  for (int c = 0; c < 3; ++c) {
    cells += fmt::format("<td class=\"n\">{:+.3f}</td>", exposure.offset[c]);
  }
  return fmt::format("<tr><td>{}</td>{}<td>{}</td></tr>", E(exposure.name), cells,
                     IsUneven(exposure) ? "uneven" : "");
}

std::string Exposures(const ReportContent& content) {
  if (content.exposures.empty()) return "";
  const std::string heading = "<h2>Exposure of the training photos</h2>";
  std::vector<PhotoExposure> order = content.exposures;
  std::stable_sort(order.begin(), order.end(),
                   [](const auto& a, const auto& b) { return DeviationOf(a) > DeviationOf(b); });
  if (DeviationOf(order.front()) < kNeutralDeviation) {
    return heading + "<p class=\"note\">Even: no photo differs by more than 1 % from the mean.</p>";
  }
  const size_t shown = std::min(order.size(), kMostExposureRows);
  std::string rows;
  for (size_t i = 0; i < shown; ++i) rows += ExposureRow(order[i]);
  return heading +
         fmt::format(
             "<p class=\"note\">A photo shows gain × field + offset in each channel (display "
             "sRGB), "
             "estimated with the field; the median of all photos is neutral (gain 1, offset 0). "
             "Uneven: more than {:.0f} % in gain or {:.2f} in offset. {} of {}, those that differ "
             "most first; exposure.json of the optimiser has all.</p>",
             100 * kUnevenGain, kUnevenOffset, shown, Plural(order.size(), "photo")) +
         "<div class=\"scroll\"><table><thead><tr><th>Photo</th><th class=\"n\">gain red</th>"
         "<th class=\"n\">green</th><th class=\"n\">blue</th><th class=\"n\">offset red</th>"
         "<th class=\"n\">green</th><th class=\"n\">blue</th><th></th></tr></thead><tbody>" +
         rows + "</tbody></table></div>";
}

std::string CameraRow(const CameraCorrection& camera) {
  return fmt::format(
      "<tr><td>{}</td><td class=\"n\">{:.2f} px</td><td class=\"n\">{:.3f}°</td>"
      "<td class=\"n\">{:.4f}</td><td>{}</td></tr>",
      E(camera.name), camera.shift_px, camera.rotation_deg, camera.move,
      MovedMuch(camera) ? "moved much" : "");
}

std::string Cameras(const ReportContent& content) {
  if (content.cameras.empty()) return "";
  std::vector<CameraCorrection> order = content.cameras;
  std::stable_sort(order.begin(), order.end(),
                   [](const auto& a, const auto& b) { return a.shift_px > b.shift_px; });
  const size_t shown = std::min(order.size(), kMostCameraRows);
  std::string rows;
  for (size_t i = 0; i < shown; ++i) rows += CameraRow(order[i]);
  return fmt::format(
             "<h2>Corrected cameras</h2><p class=\"note\">The cameras of the training photos were "
             "corrected while the field was fitted. Picture: how far the photo's picture moved, "
             "root mean square at its median depth. Centre: in world units, of which the "
             "subject's longest side has 2. {} of {}, those that moved most first; cameras.json "
             "of the optimiser has all.</p>",
             shown, Plural(order.size(), "camera")) +
         "<div class=\"scroll\"><table><thead><tr><th>Photo</th><th class=\"n\">picture</th>"
         "<th class=\"n\">turn</th><th class=\"n\">centre</th><th></th></tr></thead><tbody>" +
         rows + "</tbody></table></div>";
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

// As many views as fit into `most_bytes`.
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

std::string Convergence(const ReportContent& content) {
  std::string html = "<h2>Convergence</h2>";
  if (content.curves_svg.empty()) {
    return html + "<p class=\"note\">No curves: " + E(content.no_curves_reason) + "</p>";
  }
  const char* alts[] = {"PSNR of training batches and held-out views over seconds of optimisation",
                        "loss and number of tets over seconds of optimisation"};
  for (size_t i = 0; i < content.curves_svg.size(); ++i) {
    html += fmt::format("<div class=\"plot\"><img src=\"{}\" alt=\"{}\"></div>",
                        SvgDataUri(content.curves_svg[i]), alts[std::min<size_t>(i, 1)]);
  }
  return html;
}

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

std::string Strip(const std::vector<Image>& pictures, const std::string& what) {
  std::string html;
  for (size_t i = 0; i < pictures.size(); ++i) {
    html +=
        Picture(pictures[i], kLargeQuality,
                fmt::format("surface, {}, turned by {} degrees", what, 360 * i / pictures.size()));
  }
  return html.empty() ? "" : "<div class=\"strip\">" + html + "</div>";
}

std::string Relative(double value, double diagonal) {
  return fmt::format("{:.4g} ({:.2f} %)", value, 100 * value / diagonal);
}

std::string OtherDistances(const SurfaceScores& s) {
  std::string text;
  for (const ScoresAtDistance& at : s.at_distances) {
    if (at.threshold == s.threshold) continue;
    text += fmt::format("{}{:.3f} ({:.3g} %)", text.empty() ? "" : ", ", at.f_score,
                        100 * at.threshold / s.diagonal);
  }
  return text;
}

std::string TruthRows(const SurfaceResult& surface) {
  const SurfaceScores& s = *surface.scores;
  const auto length = [&](const std::optional<double>& value) {
    return value ? Relative(*value, s.diagonal) : std::string("–");
  };
  std::string rows =
      Row("F-score", fmt::format("{:.4f}", s.f_score),
          fmt::format("threshold {} of the subject's diagonal {:.4g}",
                      Relative(s.threshold, s.diagonal), s.diagonal)) +
      Row("Precision / recall", fmt::format("{:.4f} / {:.4f}", s.precision, s.recall),
          fmt::format("shares of {} and {} surface samples",
                      WithThousands(s.reconstruction_samples), WithThousands(s.truth_samples))) +
      Row("F-score at other distances", OtherDistances(s), "shares of the subject's diagonal") +
      Row("Angle of normals",
          s.normal_angle_deg ? fmt::format("{:.1f}°", *s.normal_angle_deg) : std::string("–"),
          "between triangles and the nearest true ones, mean where they are nearer than the "
          "threshold") +
      Row("Accuracy", length(s.accuracy), "mean distance from reconstruction to truth") +
      Row("Completeness", length(s.completeness), "mean distance from truth to reconstruction") +
      Row("Chamfer distance", length(s.chamfer), "mean of accuracy and completeness") +
      Row("Scored box",
          fmt::format("{:.3g} × {:.3g} × {:.3g}", s.crop.Size().x, s.crop.Size().y,
                      s.crop.Size().z),
          "neither surface is scored outside of it");
  if (surface.alignment) {
    const Alignment& a = *surface.alignment;
    rows += Row("Alignment residual", fmt::format("{:.4g}", a.center_rms),
                fmt::format("RMS over {} camera centres after a similarity fit (maximum {:.4g}); "
                            "directions off by {:.2f}° on average",
                            a.matched, a.center_max, a.rotation_mean_deg));
  } else {
    rows += Row("Alignment", "none", "the truth is assumed to be in the input's coordinates");
  }
  return rows;
}

std::string SurfacePictureRows(const SurfacePictures& pictures) {
  if (pictures.views.empty()) return "";
  const nlohmann::json means = SurfacePicturesJson(pictures);
  const auto number = [&](const char* name) { return means[name].get<double>(); };
  return Row("PSNR of its pictures", fmt::format("{:.2f} dB", number("psnr")),
             fmt::format("{}, over the pixels that it fills: {:.0f} % of {}; the field's "
                         "renderings have {:.2f} dB there{}",
                         pictures.textured ? "with its texture" : "in the colours of its vertices",
                         100 * number("covered"), Plural(pictures.views.size(), "view"),
                         number("field_psnr"),
                         pictures.textured ? fmt::format(", the colours of vertices {:.2f} dB",
                                                         number("vertex_color_psnr"))
                                           : ""));
}

std::string Surface(const ReportContent& content) {
  if (!content.surface) return "<h2>Surface</h2><p class=\"note\">No surface was given.</p>";
  const SurfaceResult& surface = *content.surface;
  const MeshFacts& facts = surface.facts;
  std::string rows =
      Row("Triangles / vertices",
          WithThousands(facts.faces) + " / " + WithThousands(facts.vertices), surface.file) +
      Row("Components", WithThousands(facts.components), "pieces that share no vertex") +
      Row("Watertight", facts.watertight ? "yes" : "no",
          fmt::format("{}, {}", Plural(facts.boundary_edges, "open edge"),
                      Plural(facts.non_manifold_edges, "non-manifold edge"))) +
      Row("Area", fmt::format("{:.4g}", facts.area), "in square units of the file") +
      (facts.watertight
           ? Row("Volume", fmt::format("{:.4g}", facts.volume), "in cubic units of the file")
           : "");
  if (surface.pictures) rows += SurfacePictureRows(*surface.pictures);
  if (surface.scores) rows += TruthRows(surface);
  return "<h2>Surface</h2>" + Strip(surface.color_pictures, "in its colours") +
         Strip(surface.clay_pictures, "as grey clay") +
         "<p class=\"note\">One turn around the up axis, in the field's colours and as grey clay. "
         "Back sides are blue. Cropped to the subject.</p>"
         "<div class=\"scroll\"><table><tbody>" +
         rows + "</tbody></table></div>";
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
                      Duration(TotalSeconds(run)));
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
      ScriptSource(script), E(content.dataset), kReportStyle);
  const std::string before = head + Header(content) + Cards(content) + scene +
                             ComparisonSection(content) + KeyNumbers(content) +
                             ViewScores(content) + Exposures(content) + Cameras(content) +
                             Convergence(content) + Growth(content) + Surface(content);
  const std::string after =
      Stages(content.run) + Warnings(content) + Commands(content.run) +
      "<footer>Written by tetrec-evaluate. Colours are display sRGB throughout.</footer>"
      "</main><script>" +
      script + "</script></body></html>\n";
  const size_t others = before.size() + after.size();
  return before + Views(content, others < kPageBytes ? kPageBytes - others : 1) + after;
}

}  // namespace tetrec
