// Marches rays from tet to tet through neighbour links.
#include "render/march_integrator.h"

#include "embedded_shaders.h"

namespace tetrec {
namespace {

// What every march kernel reads, and `more`.
std::vector<BindingSpec> WithMesh(std::vector<BindingSpec> more) {
  std::vector<BindingSpec> all = {
      {kBindTets, Access::kTexelRead},   {kBindVertices, Access::kTexelRead},
      {kBindHull, Access::kTexelRead},   {kBindViews, Access::kTexelRead},
      {kBindBlocks, Access::kTexelRead}, {kBindCounters, Access::kReadWrite}};
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
  std::optional<Kernels>& kernels = kernels_[field.storage == FieldStorage::kCell][any_boundary];
  if (!kernels) kernels = MakeKernels(field.storage, any_boundary);
  current_ = &*kernels;
}

MarchIntegrator::Kernels MarchIntegrator::MakeKernels(FieldStorage storage,
                                                      bool any_boundary) const {
  const auto of_rays = ConstantsOf(integral_, storage);
  const SpecializationConstant constants[] = {
      of_rays[0], of_rays[1], of_rays[2], {kConstantAnyBoundary, any_boundary}};
  const auto make = [&](const char* name, std::span<const uint32_t> spirv,
                        std::vector<BindingSpec> more) {
    return Program(device_, name, spirv, WithMesh(std::move(more)), sizeof(gpu_types::MarchPush),
                   constants);
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
  const SummingKernel colors{kMarchBackward, kMarchBackwardCas, kMarchBackwardFixed};
  kernels.backward = make("march_backward", colors.For(device_, fixed_point_), backward);
  backward.push_back({kBindPositionGradients, Access::kReadWrite});
  const SummingKernel positions{kMarchBackwardPositions, kMarchBackwardPositionsCas,
                                kMarchBackwardPositionsFixed};
  kernels.backward_positions =
      make("march_backward (positions)", positions.For(device_, fixed_point_), backward);
  const SummingKernel scores{kMarchScore, kMarchScoreCas, kMarchScoreFixed};
  kernels.score = make("march_score", scores.For(device_, fixed_point_),
                       {{kBindRayEntries, Access::kRead},
                        {kBindRayGradients, Access::kRead},
                        {kBindTetScores, Access::kReadWrite}});
  return kernels;
}

void MarchIntegrator::Forward(CommandRecorder& recorder, const RayPass& pass) {
  Dispatch(recorder, pass.count_steps ? current_->forward_counting : current_->forward, pass,
           {&pass.rays.colors, &pass.rays.entries});
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
