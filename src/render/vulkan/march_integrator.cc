// Marches rays from tet to tet through neighbour links.
#include "render/vulkan/march_integrator.h"

#include "embedded_shaders.h"
#include "render/vulkan/loop_bound.h"

#include <algorithm>

namespace tetrec {
namespace {

// A step's own loops, those of rare branches, and the sums of the vertex that leaves.
constexpr LoopCost kStepCost{.rounds = 6, .sums = 8};

uint32_t NumberOf(ScoreKind kind) {
  switch (kind) {
    case ScoreKind::kSquaredResidual:
      return kScoreSquaredResidual;
    case ScoreKind::kAbsoluteResidual:
      return kScoreAbsoluteResidual;
  }
  return kScoreSquaredResidual;
}

}  // namespace

MarchIntegrator::MarchIntegrator(const Device& device, const RendererOptions& options)
    : device_(device),
      integral_(options.integral),
      fixed_point_(options.deterministic),
      max_steps_(std::min(options.max_steps, MostItems(device, options, kStepCost))) {}

void MarchIntegrator::SetField(const DeviceField& field) {
  const bool any_boundary = field.tree_leaves > 0;
  const std::tuple key(field.layout.storage == FieldStorage::kCell,
                       field.layout.HarmonicsDegree() > 0, any_boundary);
  if (!kernels_.contains(key)) kernels_.emplace(key, MakeKernels(field.layout, any_boundary));
  current_ = &kernels_.at(key);
}

MarchIntegrator::Kernels MarchIntegrator::MakeKernels(const FieldLayout& layout,
                                                      bool any_boundary) const {
  // Kernels that follow rays only ask whether colours depend on the view.
  FieldLayout kind{.storage = layout.storage};
  if (layout.HarmonicsDegree() > 0) kind.attributes.push_back(HarmonicsAttribute(1));
  std::vector<SpecializationConstant> constants = ConstantsOf(integral_, kind);
  constants.push_back({kConstantAnyBoundary, any_boundary});
  std::vector<SpecializationConstant> for_motion = constants;
  for_motion.push_back({kConstantAbsoluteSums, 0});
  const auto make = [&](const char* name, std::span<const uint32_t> spirv) {
    return Program(device_, name, spirv, constants);
  };
  const SummingKernel colors{kMarchBackward, kMarchBackwardCas, kMarchBackwardFixed};
  const SummingKernel positions{kMarchBackwardPositions, kMarchBackwardPositionsCas,
                                kMarchBackwardPositionsFixed};
  const SummingKernel scores{kMarchScore, kMarchScoreCas, kMarchScoreFixed};
  const SummingKernel edges{kMarchEdges, kMarchEdgesCas, kMarchEdgesFixed};
  Kernels kernels;
  kernels.forward = make("march_forward", kMarchForward);
  kernels.forward_counting = make("march_forward (counting)", kMarchForwardCounting);
  kernels.forward_depth = make("march_forward (depth)", kMarchForwardDepth);
  kernels.backward = make("march_backward", colors.For(device_, fixed_point_));
  kernels.backward_positions =
      make("march_backward (positions)", positions.For(device_, fixed_point_));
  kernels.backward_motion =
      Program(device_, "march_backward (motion)", positions.For(device_, fixed_point_), for_motion);
  kernels.score = make("march_score", scores.For(device_, fixed_point_));
  kernels.edges = make("march_edges", edges.For(device_, fixed_point_));
  return kernels;
}

gpu_types::MarchPush MarchIntegrator::PushOf(const RayPass& pass) const {
  return {.rays = pass.push,
          .hull_faces = pass.field.hull_faces,
          .hull_planes = pass.field.hull_planes,
          .tree_leaves = pass.field.tree_leaves,
          .mesh_ball = pass.field.ball,
          .background = glm::vec4(0.0f),
          .max_steps = max_steps_,
          .score = NumberOf(pass.score),
          .row_count = pass.field.row_count};
}

void MarchIntegrator::Dispatch(CommandRecorder& recorder, const Program& program,
                               const RayPass& pass, const BoundBuffers& more) const {
  Dispatch(recorder, program, pass, more, PushOf(pass));
}

void MarchIntegrator::Dispatch(CommandRecorder& recorder, const Program& program,
                               const RayPass& pass, const BoundBuffers& more,
                               const gpu_types::MarchPush& push) const {
  BoundBuffers buffers = MeshAnd(pass, more);
  buffers.insert(buffers.end(), {{kBindHull, pass.field.hull}, {kBindCounters, pass.counters}});
  recorder.Dispatch(program, buffers, push, pass.push.ray_count);
}

void MarchIntegrator::Forward(CommandRecorder& recorder, const RayPass& pass) {
  Dispatch(recorder, pass.count_steps ? current_->forward_counting : current_->forward, pass,
           {{kBindRayColors, pass.rays.colors}, {kBindRayEntries, pass.rays.entries}});
}

void MarchIntegrator::ForwardWithReaches(CommandRecorder& recorder, const RayPass& pass,
                                         const Buffer& reaches) {
  Dispatch(recorder, current_->forward_depth, pass,
           {{kBindRayColors, pass.rays.colors},
            {kBindRayEntries, pass.rays.entries},
            {kBindRayReaches, reaches}});
}

void MarchIntegrator::Backward(CommandRecorder& recorder, const RayPass& pass) {
  const bool with_positions = HasPositions(pass.parts);
  BoundBuffers buffers = {{kBindRayColors, pass.rays.colors},
                          {kBindRayEntries, pass.rays.entries},
                          {kBindRayGradients, pass.rays.gradients},
                          {kBindVertexGradients, *pass.gradients}};
  if (with_positions) {
    buffers.emplace_back(kBindPositionGradients, pass.field.position_gradients);
  }
  const Program& program = pass.parts == GradientParts::kMotion ? current_->backward_motion
                           : with_positions                     ? current_->backward_positions
                                                                : current_->backward;
  Dispatch(recorder, program, pass, buffers);
}

void MarchIntegrator::Score(CommandRecorder& recorder, const RayPass& pass) {
  Dispatch(recorder, current_->score, pass,
           {{kBindRayEntries, pass.rays.entries},
            {kBindRayGradients, pass.rays.gradients},
            {kBindTetScores, pass.field.tet_scores}});
}

void MarchIntegrator::AddEdgeSums(CommandRecorder& recorder, const RayPass& pass,
                                  const EdgeGather& edges, const glm::vec3& background) {
  gpu_types::MarchPush push = PushOf(pass);
  push.background = glm::vec4(background, 0.0f);
  Dispatch(recorder, current_->edges, pass,
           {{kBindRayColors, pass.rays.colors},
            {kBindRayEntries, pass.rays.entries},
            {kBindRayGradients, pass.rays.gradients},
            {kBindTetEdges, edges.tet_edges()},
            {kBindEdgeSums, edges.sums()}},
           push);
}

}  // namespace tetrec
