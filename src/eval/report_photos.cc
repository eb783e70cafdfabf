// The training photos of the report: their exposures and their corrected cameras.
#include "eval/report_sections.h"
#include "eval/report_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace tetrec::report {
namespace {

constexpr size_t kMostExposureRows = 100, kMostCameraRows = 100;
constexpr double kNeutralDeviation = 0.01;  // of log gain and of offset

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

std::string CameraRow(const CameraCorrection& camera) {
  return fmt::format(
      "<tr><td>{}</td><td class=\"n\">{:.2f} px</td><td class=\"n\">{:.3f}°</td>"
      "<td class=\"n\">{:.4f}</td><td>{}</td></tr>",
      E(camera.name), camera.shift_px, camera.rotation_deg, camera.move,
      MovedMuch(camera) ? "moved much" : "");
}

}  // namespace

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

}  // namespace tetrec::report
