// Cameras as kernels see them.
#include "render/vulkan/gpu_view.h"

namespace tetrec {

using gpu_types::GpuView;

GpuView MakeGpuView(const RenderView& view, int grid, uint32_t first_pixel, uint32_t start_tet) {
  const Rigid3 world_from_cam = view.cam_from_world.Inverse();
  const Camera& camera = view.camera;
  GpuView result;
  result.right_in_world_fx = glm::vec4(glm::dvec4(world_from_cam.rotation[0], grid * camera.fx));
  result.down_in_world_fy = glm::vec4(glm::dvec4(world_from_cam.rotation[1], grid * camera.fy));
  result.forward_in_world_cx = glm::vec4(glm::dvec4(world_from_cam.rotation[2], grid * camera.cx));
  result.center_in_world_cy = glm::vec4(glm::dvec4(world_from_cam.translation, grid * camera.cy));
  result.size_pixel_tet = glm::uvec4(uint32_t(grid * camera.width), uint32_t(grid * camera.height),
                                     first_pixel, start_tet);
  return result;
}

}  // namespace tetrec
