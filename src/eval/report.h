// report.html: one self-contained page about a run.
#pragma once

#include "eval/evaluate_depth.h"
#include "eval/evaluate_normals.h"
#include "eval/evaluate_surface.h"
#include "eval/run_facts.h"
#include "run/camera_corrections.h"
#include "run/mesh_growth.h"
#include "run/photo_exposures.h"
#include "run/rendered_views.h"
#include "scene/scene.h"

#include <nlohmann/json.hpp>

#include <optional>
#include <string>
#include <vector>

namespace tetrec {

struct ViewScore {
  std::string name;
  int width = 0, height = 0;              // [px]
  double mse = 0, psnr = 0, ssim = 0;     // psnr may be infinite
  std::optional<double> foreground_psnr;  // if there is a mask
  // Standard deviations of the brightness over all pixels [8-bit levels].
  double render_contrast = 0, truth_contrast = 0;
  // Of the right half of the view: as it is rendered, and with the colours that were fitted on the
  // left half (color_correction.h). Nothing if a half has no pixel to score.
  std::optional<double> right_half_psnr, corrected_psnr;
  // With refined cameras (RenderedView::refined): of the whole view, and as corrected_psnr.
  std::optional<double> refined_psnr, refined_corrected_psnr, refined_shift_px;
};

struct ReportContent {
  std::string dataset;
  RenderedViews rendered;
  std::vector<ViewScore> scores;  // one per rendered view, in the same order
  RunFacts run;
  std::vector<PhotoExposure> exposures;   // of the training photos; empty if not estimated
  std::vector<CameraCorrection> cameras;  // of the training photos; empty if none were kept
  std::optional<Scene> scene;             // nothing if the chain of manifests is broken
  std::optional<SurfaceResult> surface;
  std::optional<DepthScores> depth;
  std::optional<NormalScores> normals;
  std::vector<GrowthStep> growth;       // of the mesh; empty if unknown
  std::string growth_svg;               // size against gain; empty if there is none
  std::vector<std::string> curves_svg;  // convergence; if empty, no_curves_reason is shown
  std::string no_curves_reason;
  nlohmann::json metrics;  // as in metrics.json: the numbers of the page
  std::vector<std::string> warnings;
};

// The page loads nothing and runs only its own script, which moves the sliders and draws the 3-D
// scene (a content security policy forbids the rest); every text is escaped. It stays below 15 MB:
// views stop when they fill what all else leaves, and the page states how many of them are shown.
std::string MakeReport(const ReportContent& content);

}  // namespace tetrec
