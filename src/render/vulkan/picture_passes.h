// Passes over the pixels of one view: colours, depths, gradients.
#pragma once

#include "gpu/commands.h"
#include "render/probe.h"
#include "render/vulkan/march_integrator.h"
#include "render/vulkan/pass_counters.h"
#include "render/vulkan/view_colors.h"

#include <span>
#include <vector>

namespace tetrec {

// Every call returns when the device is done, which must be idle before.
class PicturePasses {
 public:
  PicturePasses(const Device& device, const RendererOptions& options, PassCounters& counters,
                ViewColors& view_colors);

  // As Renderer and RendererProbe describe them.
  RenderedImage Render(Integrator& integrator, DeviceField& field, const RenderView& view,
                       int samples);
  DepthMap RenderDepth(MarchIntegrator& march, DeviceField& field, const RenderView& view,
                       double optical_depth);
  std::vector<glm::vec4> MarchBlocks(Integrator& integrator, DeviceField& field,
                                     const RenderView& view, std::span<const RayBlock> blocks);
  // Adds the gradients of an image to the field's sums.
  void Backpropagate(Integrator& integrator, DeviceField& field, const RenderView& view,
                     std::span<const glm::vec4> pixel_gradient, GradientParts parts,
                     const FixedPoint& fixed);

 private:
  void SetView(const DeviceField& field, const RenderView& view, int samples);
  RayPass PassOver(DeviceField& field, std::span<const RayBlock> blocks, const FixedPoint& fixed);
  std::vector<glm::vec4> MarchBatch(Integrator& integrator, DeviceField& field,
                                    std::span<const RayBlock> blocks);
  std::vector<float> ReachesOfBatch(MarchIntegrator& march, DeviceField& field,
                                    std::span<const RayBlock> blocks, double optical_depth);
  // Submits what `record` records, and waits.
  template <class Record>
  void Submit(const Record& record);

  const Device& device_;
  const RendererOptions& options_;
  PassCounters& counters_;
  ViewColors& view_colors_;
  CommandRecorder recorder_;
  Buffer view_;
  gpu_types::GpuView gpu_view_;  // as in view_
  RayBatch rays_;
};

}  // namespace tetrec
