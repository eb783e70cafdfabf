// Marches rays from tet to tet through neighbour links (shaders/march.glsl).
#pragma once

#include "gpu/program.h"
#include "render/vulkan/edge_gather.h"
#include "render/vulkan/integrator.h"

#include <map>
#include <tuple>

namespace tetrec {

class MarchIntegrator final : public Integrator {
 public:
  MarchIntegrator(const Device& device, const RendererOptions& options);
  void SetField(const DeviceField& field) override;
  void Forward(CommandRecorder& recorder, const RayPass& pass) override;
  void Backward(CommandRecorder& recorder, const RayPass& pass) override;
  // As Forward; also fills `reaches` (a float per ray) with the distances from the camera at which
  // the rays reach the optical depth at which they stop, 0 for those that never do.
  void ForwardWithReaches(CommandRecorder& recorder, const RayPass& pass, const Buffer& reaches);
  // Records the commands that add to field.tet_scores; follows Forward and the loss.
  void Score(CommandRecorder& recorder, const RayPass& pass);
  // The same for the sums of edges of rays in front of a background [display sRGB].
  void AddEdgeSums(CommandRecorder& recorder, const RayPass& pass, const EdgeGather& edges,
                   const glm::vec3& background);

 private:
  struct Kernels {
    Program forward, forward_counting, forward_depth, backward, backward_positions, backward_motion,
        score, edges;
  };
  Kernels MakeKernels(const FieldLayout& layout, bool any_boundary) const;
  // Binds what every march kernel reads, and `more`.
  void Dispatch(CommandRecorder& recorder, const Program& program, const RayPass& pass,
                const BoundBuffers& more) const;
  void Dispatch(CommandRecorder& recorder, const Program& program, const RayPass& pass,
                const BoundBuffers& more, const gpu_types::MarchPush& push) const;
  gpu_types::MarchPush PushOf(const RayPass& pass) const;

  const Device& device_;
  IntegralOptions integral_;
  bool fixed_point_;  // sums as in DeviceField::fixed_point
  uint32_t max_steps_;
  // By whether cells have the attributes, whether colours depend on the view, and whether the
  // boundary may have any shape (or is convex, of few faces); made when first needed.
  std::map<std::tuple<bool, bool, bool>, Kernels> kernels_;
  const Kernels* current_ = nullptr;
};

}  // namespace tetrec
