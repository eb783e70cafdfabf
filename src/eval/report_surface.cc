// The surface of the report.
#include "core/progress.h"
#include "eval/report_sections.h"
#include "eval/report_text.h"

#include <fmt/format.h>

#include <optional>
#include <vector>

namespace tetrec::report {
namespace {

constexpr int kPictureQuality = 90;

std::string Strip(const std::vector<Image>& pictures, const std::string& what) {
  std::string html;
  for (size_t i = 0; i < pictures.size(); ++i) {
    html +=
        Picture(pictures[i], kPictureQuality,
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

}  // namespace

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

}  // namespace tetrec::report
