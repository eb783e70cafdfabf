// The integrators of a renderer: the march, which scores and depths need, and the one that renders.
#pragma once

#include "render/vulkan/march_integrator.h"

#include <memory>

namespace tetrec {

class Integrators {
 public:
  // Kernels know where rows of this layout keep their attributes.
  Integrators(const Device& device, const RendererOptions& options, const FieldLayout& layout);

  // Makes the kernels for another layout. The device must be idle.
  void UseLayout(const FieldLayout& layout);

  MarchIntegrator& march() { return march_; }
  Integrator& rendering() { return other_ ? *other_ : march_; }
  bool march_renders() const { return !other_; }

  // As Integrator's.
  uint64_t BytesFor(const TetMesh& mesh) const;
  void SetField(const DeviceField& field);
  void FollowVertices(const DeviceField& field);

 private:
  const Device& device_;
  RendererOptions options_;
  MarchIntegrator march_;
  std::unique_ptr<Integrator> other_;  // unless the march renders
};

}  // namespace tetrec
