// Marches rays from tet to tet through neighbour links (shaders/march.glsl).
#pragma once

#include "gpu/program.h"
#include "render/integrator.h"

namespace tetrec {

class MarchIntegrator final : public Integrator {
 public:
  // `fixed_point`: sums as in DeviceField::fixed_point.
  MarchIntegrator(const Device& device, const IntegralOptions& integral, FieldStorage storage,
                  bool fixed_point);
  void Forward(CommandRecorder& recorder, const RayPass& pass) override;
  void Backward(CommandRecorder& recorder, const RayPass& pass) override;
  // Records what adds to field.tet_scores, after Forward and the loss.
  void Score(CommandRecorder& recorder, const RayPass& pass);

 private:
  Program forward_, forward_counting_, backward_, backward_positions_, score_;
};

}  // namespace tetrec
