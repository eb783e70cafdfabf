// Counts of rays and moves.
#include "optimize/run_counts.h"

#include "core/log.h"
#include "core/progress.h"

#include <cstdint>

namespace tetrec {
namespace {

// The article's moves may break the mesh.
void ReportDegenerate(const TetMesh& mesh, Stage& stage) {
  const uint64_t degenerate = CountDegenerateTets(mesh);
  stage.Count("degenerate_tets", degenerate);
  if (degenerate == 0) return;
  LogWarning(
      "{} of {} tets are inside out or flat, so the field shows parts of space twice or not at "
      "all: use safe moves or a lower rate of positions",
      WithThousands(degenerate), WithThousands(mesh.tets.size()));
}

}  // namespace

void ReportRays(const RenderCounts& counts, const RendererOptions& options, Stage& stage) {
  stage.Count("rays", counts.rays);
  if (ChecksRays(options)) stage.Count("lost_rays", counts.lost_rays);
  if (options.deterministic) stage.Count("clamped_addends", counts.clamped_addends);
  if (counts.lost_rays > 0) {
    LogWarning("{} of {} rays were lost on their way through the mesh", counts.lost_rays,
               WithThousands(counts.rays));
  }
  if (counts.clamped_addends > 0) {
    LogWarning("{} addends were too large for the fixed-point sums of gradients and scores",
               WithThousands(counts.clamped_addends));
  }
}

void ReportMotion(const VertexMotion& motion, const TetMesh& mesh, Stage& stage) {
  const MotionCounts& counts = motion.counts();
  if (counts.all() == 0) return;
  const TetMeshQuality quality = MeasureQuality(mesh);
  const double all = double(counts.all());
  stage.Count("vertex_moves", counts.all());
  stage.Count("shortened_moves", counts.shortened);
  stage.Count("stopped_moves", counts.stopped);
  stage.Count("min_volume", quality.min_volume);
  stage.Count("min_radius_ratio", quality.min_radius_ratio);
  ReportDegenerate(mesh, stage);
  LogInfo(
      "vertices moved {} times ({:.1f} s since the start or resume), {:.1f} % of the moves "
      "shortened and {:.1f} % stopped "
      "for the sake of tets; smallest tet {:.1e}, smallest radius ratio {:.1e}",
      WithThousands(counts.all()), motion.seconds(), 100.0 * double(counts.shortened) / all,
      100.0 * double(counts.stopped) / all, quality.min_volume, quality.min_radius_ratio);
}

}  // namespace tetrec
