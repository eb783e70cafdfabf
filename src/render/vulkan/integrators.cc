// The integrators of a renderer: the march, which scores and depths need, and the one that renders.
#include "render/vulkan/integrators.h"

#include "render/vulkan/ppll_integrator.h"
#include "render/vulkan/projection_integrator.h"

namespace tetrec {

Integrators::Integrators(const Device& device, const RendererOptions& options,
                         const FieldLayout& layout)
    : device_(device), options_(options), march_(device, options) {
  UseLayout(layout);
}

void Integrators::UseLayout(const FieldLayout& layout) {
  if (options_.kind == RendererKind::kPpll) {
    other_ = std::make_unique<PpllIntegrator>(device_, options_, layout);
  } else if (options_.kind == RendererKind::kProjection) {
    other_ = std::make_unique<ProjectionIntegrator>(device_, options_, layout);
  }
}

uint64_t Integrators::BytesFor(const TetMesh& mesh) const {
  return march_.BytesFor(mesh) + (other_ ? other_->BytesFor(mesh) : 0);
}

void Integrators::SetField(const DeviceField& field) {
  march_.SetField(field);
  if (other_) other_->SetField(field);
}

void Integrators::FollowVertices(const DeviceField& field) {
  if (other_) other_->FollowVertices(field);
}

}  // namespace tetrec
