// What the manifest counts of a run's rays and moves, and the warnings that follow from it.
#pragma once

#include "core/stage.h"
#include "mesh/tet_mesh.h"
#include "optimize/vertex_motion.h"
#include "render/renderer.h"

namespace tetrec {

// `counts`: of all rays, those of judging and watching too.
void ReportRays(const RenderCounts& counts, const RendererOptions& options, Stage& stage);

// Nothing if no vertex has moved.
void ReportMotion(const VertexMotion& motion, const TetMesh& mesh, Stage& stage);

}  // namespace tetrec
