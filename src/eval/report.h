// report.html: one self-contained page about a run.
#pragma once

#include "eval/alignment.h"
#include "eval/mesh_facts.h"
#include "eval/mesh_metrics.h"
#include "eval/rendered_views.h"
#include "eval/run_facts.h"
#include "scene/image.h"

#include <nlohmann/json.hpp>

#include <optional>
#include <string>
#include <vector>

namespace tetrec {

struct ViewScore {
  std::string name;
  double mse = 0, psnr = 0, ssim = 0;     // psnr may be infinite
  std::optional<double> foreground_psnr;  // where there is a mask
};

struct SurfaceResult {
  std::string file;                     // as the surface stage names it
  MeshFacts facts;                      // in the input's units
  std::optional<SurfaceScores> scores;  // with a ground-truth mesh
  std::optional<Alignment> alignment;   // with true cameras
  std::vector<Image> color_pictures, clay_pictures;
};

struct ReportContent {
  std::string dataset;
  RenderedViews rendered;
  std::vector<ViewScore> scores;  // one a rendered view, in the same order
  RunFacts run;
  std::optional<SurfaceResult> surface;
  std::vector<std::string> curves_svg;  // convergence; empty: say why
  std::string no_curves_reason;
  nlohmann::json metrics;  // as in metrics.json: the numbers of the page
  std::vector<std::string> warnings;
};

// No script, nothing loaded from elsewhere (a content security policy forbids it), every text
// escaped. Stays below 8 MiB: thumbnails stop when they fill half of it, and the page says how many
// were left out.
std::string MakeReport(const ReportContent& content);

}  // namespace tetrec
