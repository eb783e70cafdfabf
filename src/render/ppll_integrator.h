// Per-pixel lists: rasterises the faces of the mesh, sorts every ray's hits, resolves them
// (shaders/ppll.glsl).
#pragma once

#include "gpu/program.h"
#include "render/fragment_tiles.h"
#include "render/integrator.h"

#include <vector>

namespace tetrec {

// Batches must be tiles. MarchPush::max_steps bounds nothing here: a list ends by itself.
class PpllIntegrator final : public Integrator {
 public:
  // Throws EnvironmentError where the device cannot rasterise.
  PpllIntegrator(const Device& device, const RendererOptions& options, FieldStorage storage);
  uint64_t BytesFor(const TetMesh& mesh) const override;
  void SetField(const DeviceField& field) override;
  // Counts, waits, then fills, sorts and resolves tile by tile. Throws EnvironmentError where the
  // list of one ray alone exceeds the memory for fragments.
  void Forward(CommandRecorder& recorder, const RayPass& pass) override;
  void Backward(CommandRecorder& recorder, const RayPass& pass) override;

 private:
  gpu_types::PpllPush PushOf(const RayPass& pass, const FragmentTile& tile) const;
  void DrawFaces(CommandRecorder& recorder, const RayPass& pass, const FragmentTile& tile,
                 bool only_counts);
  void PlanTiles(CommandRecorder& recorder, const RayPass& pass);
  void LoadTile(CommandRecorder& recorder, const RayPass& pass, const FragmentTile& tile);
  void Sort(CommandRecorder& recorder, const RayPass& pass, const FragmentTile& tile);

  const Device& device_;
  uint64_t fragment_capacity_;
  uint32_t longest_list_;  // that the device can walk
  FragmentSort sort_;
  Program faces_program_, sort_shell_, sort_heap_;
  Program forward_, forward_counting_, backward_, backward_positions_;
  Buffer faces_, lists_, list_fills_, fragments_;
  uint32_t face_count_ = 0;
  glm::vec4 mesh_ball_{0.0f};
  std::vector<FragmentTile> tiles_;  // of the batch of the last Forward; the last one is loaded
};

}  // namespace tetrec
