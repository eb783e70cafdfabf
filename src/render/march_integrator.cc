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
                                 bool fixed_point)
    : device_(device), integral_(integral), fixed_point_(fixed_point) {}

void MarchIntegrator::SetField(const DeviceField& field) {
  const bool any_boundary = field.tree_leaves > 0;
  std::optional<Kernels>& kernels = kernels_[any_boundary];
  if (!kernels) kernels = MakeKernels(any_boundary);
  current_ = &*kernels;
}

MarchIntegrator::Kernels MarchIntegrator::MakeKernels(bool any_boundary) const {
  const auto integral = ConstantsOf(integral_);
  const SpecializationConstant constants[] = {
      integral[0], integral[1], {kConstantAnyBoundary, any_boundary}};
  const auto make = [&](const char* name, std::span<const uint32_t> spirv,
                        std::vector<BindingSpec> more) {
    return Program(device_, name, spirv, WithMesh(std::move(more)), sizeof(gpu_types::MarchPush),
                   constants);
  };
  const auto with_atomics = [&](std::span<const uint32_t> native,
                                std::span<const uint32_t> compare_and_swap,
                                std::span<const uint32_t> fixed) {
    if (fixed_point_) return fixed;
    return device_.has_float_atomics ? native : compare_and_swap;
  };
  const std::vector<BindingSpec> results = {{kBindRayColors, Access::kWrite},
                                            {kBindRayEntries, Access::kWrite}};
  Kernels kernels;
  kernels.forward = make("march_forward", kMarchForward, results);
  kernels.forward_counting = make("march_forward (counting)", kMarchForwardCounting, results);
  std::vector<BindingSpec> backward = {{kBindRayColors, Access::kRead},
                                       {kBindRayEntries, Access::kRead},
                                       {kBindRayGradients, Access::kRead},
                                       {kBindVertexGradients, Access::kReadWrite}};
  kernels.backward =
      make("march_backward", with_atomics(kMarchBackward, kMarchBackwardCas, kMarchBackwardFixed),
           backward);
  backward.push_back({kBindPositionGradients, Access::kReadWrite});
  kernels.backward_positions =
      make("march_backward (positions)",
           with_atomics(kMarchBackwardPositions, kMarchBackwardPositionsCas,
                        kMarchBackwardPositionsFixed),
           backward);
  kernels.score = make("march_score", with_atomics(kMarchScore, kMarchScoreCas, kMarchScoreFixed),
                       {{kBindRayEntries, Access::kRead},
                        {kBindRayGradients, Access::kRead},
                        {kBindTetScores, Access::kReadWrite}});
  return kernels;
}

void MarchIntegrator::Forward(CommandRecorder& recorder, const RayPass& pass) {
  Dispatch(recorder, current_->forward, pass, {&pass.rays.colors, &pass.rays.entries});
}

void MarchIntegrator::ForwardCounting(CommandRecorder& recorder, const RayPass& pass) {
  Dispatch(recorder, current_->forward_counting, pass, {&pass.rays.colors, &pass.rays.entries});
}

void MarchIntegrator::Backward(CommandRecorder& recorder, const RayPass& pass) {
  if (pass.parts == GradientParts::kColorDensityPosition) {
    Dispatch(recorder, current_->backward_positions, pass,
             {&pass.rays.colors, &pass.rays.entries, &pass.rays.gradients, &pass.field.gradients,
              &pass.field.position_gradients});
  } else {
    Dispatch(recorder, current_->backward, pass,
             {&pass.rays.colors, &pass.rays.entries, &pass.rays.gradients, &pass.field.gradients});
  }
}

void MarchIntegrator::Score(CommandRecorder& recorder, const RayPass& pass) {
  Dispatch(recorder, current_->score, pass,
           {&pass.rays.entries, &pass.rays.gradients, &pass.field.tet_scores});
}

}  // namespace tetrec
