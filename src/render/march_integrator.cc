// Marches rays from tet to tet through neighbour links.
#include "render/march_integrator.h"

#include "embedded_shaders.h"

namespace tetrec {
namespace {

// What every march kernel reads, and `more`.
std::vector<BindingSpec> WithMesh(std::vector<BindingSpec> more) {
  std::vector<BindingSpec> all = {
      {kBindTets, Access::kTexelRead}, {kBindVertices, Access::kTexelRead},
      {kBindHull, Access::kTexelRead}, {kBindViews, Access::kRead},
      {kBindBlocks, Access::kRead},    {kBindCounters, Access::kReadWrite}};
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

void Dispatch(CommandRecorder& recorder, const Program& program, const RayPass& pass,
              std::initializer_list<const Buffer*> more) {
  std::vector<const Buffer*> buffers = {&pass.field.tets, &pass.field.vertices, &pass.field.hull,
                                        &pass.views,      &pass.rays.blocks,    &pass.counters};
  buffers.insert(buffers.end(), more);
  recorder.Dispatch(program, buffers, pass.push, pass.push.ray_count, kWorkgroupSize);
}

}  // namespace

MarchIntegrator::MarchIntegrator(const Device& device, const IntegralOptions& integral,
                                 FieldStorage storage, bool fixed_point) {
  const auto constants = ConstantsOf(integral, storage);
  const auto make = [&](const char* name, std::span<const uint32_t> spirv,
                        std::vector<BindingSpec> more) {
    return Program(device, name, spirv, WithMesh(std::move(more)), sizeof(gpu_types::MarchPush),
                   constants);
  };
  const std::vector<BindingSpec> results = {{kBindRayColors, Access::kWrite},
                                            {kBindRayEntries, Access::kWrite}};
  forward_ = make("march_forward", kMarchForward, results);
  forward_counting_ = make("march_forward (counting)", kMarchForwardCounting, results);
  std::vector<BindingSpec> backward = {{kBindRayColors, Access::kRead},
                                       {kBindRayEntries, Access::kRead},
                                       {kBindRayGradients, Access::kRead},
                                       {kBindVertexGradients, Access::kReadWrite}};
  const SummingKernel colors{kMarchBackward, kMarchBackwardCas, kMarchBackwardFixed};
  backward_ = make("march_backward", colors.For(device, fixed_point), backward);
  backward.push_back({kBindPositionGradients, Access::kReadWrite});
  const SummingKernel positions{kMarchBackwardPositions, kMarchBackwardPositionsCas,
                                kMarchBackwardPositionsFixed};
  backward_positions_ =
      make("march_backward (positions)", positions.For(device, fixed_point), backward);
  const SummingKernel scores{kMarchScore, kMarchScoreCas, kMarchScoreFixed};
  score_ = make("march_score", scores.For(device, fixed_point),
                {{kBindRayEntries, Access::kRead},
                 {kBindRayGradients, Access::kRead},
                 {kBindTetScores, Access::kReadWrite}});
}

void MarchIntegrator::Forward(CommandRecorder& recorder, const RayPass& pass) {
  Dispatch(recorder, pass.count_steps ? forward_counting_ : forward_, pass,
           {&pass.rays.colors, &pass.rays.entries});
}

void MarchIntegrator::Backward(CommandRecorder& recorder, const RayPass& pass) {
  if (pass.parts == GradientParts::kColorDensityPosition) {
    Dispatch(recorder, backward_positions_, pass,
             {&pass.rays.colors, &pass.rays.entries, &pass.rays.gradients, &pass.field.gradients,
              &pass.field.position_gradients});
  } else {
    Dispatch(recorder, backward_, pass,
             {&pass.rays.colors, &pass.rays.entries, &pass.rays.gradients, &pass.field.gradients});
  }
}

void MarchIntegrator::Score(CommandRecorder& recorder, const RayPass& pass) {
  Dispatch(recorder, score_, pass,
           {&pass.rays.entries, &pass.rays.gradients, &pass.field.tet_scores});
}

}  // namespace tetrec
