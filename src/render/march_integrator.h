// Marches rays from tet to tet through neighbour links (shaders/march.glsl).
#pragma once

#include "gpu/program.h"
#include "render/integrator.h"

#include <array>
#include <optional>

namespace tetrec {

class MarchIntegrator final : public Integrator {
 public:
  // `fixed_point`: sums as in DeviceField::fixed_point.
  MarchIntegrator(const Device& device, const IntegralOptions& integral, bool fixed_point);
  void SetField(const DeviceField& field) override;
  void Forward(CommandRecorder& recorder, const RayPass& pass) override;
  void Backward(CommandRecorder& recorder, const RayPass& pass) override;
  // Records what adds to field.tet_scores, after Forward and the loss.
  void Score(CommandRecorder& recorder, const RayPass& pass);

 private:
  struct Kernels {
    Program forward, forward_counting, backward, backward_positions, score;
  };
  Kernels MakeKernels(FieldStorage storage, bool any_boundary) const;

  const Device& device_;
  IntegralOptions integral_;
  bool fixed_point_;
  // By storage; for convex boundaries of few faces, for any boundary; made when first needed.
  std::array<std::array<std::optional<Kernels>, 2>, 2> kernels_;
  const Kernels* current_ = nullptr;
};

}  // namespace tetrec
