// Per-pixel lists: rasterises the faces of the mesh, sorts every ray's hits, resolves them
// (shaders/ppll.glsl).
#pragma once

#include "gpu/program.h"
#include "render/vulkan/fragment_tiles.h"
#include "render/vulkan/integrator.h"

#include <vector>

namespace tetrec {

// A ball that contains kFacesPerChunk faces of the mesh.
struct FaceChunk {
  glm::dvec3 center;
  double radius;
};

// Batches must be tiles. RendererOptions::max_steps is not needed here: a list ends by itself.
class PpllIntegrator final : public Integrator {
 public:
  // Throws EnvironmentError if the device cannot rasterise.
  PpllIntegrator(const Device& device, const RendererOptions& options, const FieldLayout& layout);
  uint64_t BytesFor(const TetMesh& mesh) const override;
  void SetField(const DeviceField& field) override;
  // Draws, waits, then sorts and resolves. If the fragments did not fit, draws, sorts and resolves
  // again tile by tile, within the sizes that the first draw counted. Throws EnvironmentError if
  // the list of a single ray exceeds the memory for fragments.
  void Forward(CommandRecorder& recorder, const RayPass& pass) override;
  void Backward(CommandRecorder& recorder, const RayPass& pass) override;

 private:
  gpu_types::PpllPush PushOf(const RayPass& pass, const FragmentTile& tile) const;
  void CullFaces(const RayPass& pass, std::span<const FragmentTile> tiles);
  void DrawFaces(CommandRecorder& recorder, const RayPass& pass, const FragmentTile& tile, size_t i,
                 bool appends);
  std::vector<uint32_t> CountFragments(CommandRecorder& recorder, const RayPass& pass);
  void PlanTiles(CommandRecorder& recorder, const RayPass& pass);
  void Keep(const RayPass& pass, uint64_t all, uint64_t most);
  void LoadTile(CommandRecorder& recorder, const RayPass& pass, size_t i);
  void Sort(CommandRecorder& recorder, const RayPass& pass, const FragmentTile& tile);

  const Device& device_;
  uint64_t fragment_memory_, fragment_capacity_;
  uint32_t longest_list_;  // the longest that the device can walk
  FragmentSort sort_;
  Program faces_program_, gather_, sort_shell_, sort_heap_;
  Program forward_, forward_counting_, backward_, backward_positions_;
  Buffer faces_, visible_chunks_, lists_, list_fills_, appended_, fragments_;
  std::vector<FaceChunk> face_chunks_;
  std::vector<size_t> first_visible_;  // one per tile, and the end, in visible_chunks_
  uint32_t face_count_ = 0;
  uint64_t appended_count_ = 0;      // fragments of the whole batch if all are appended, else 0
  std::vector<FragmentTile> tiles_;  // of the batch of the last Forward; the last one is loaded
};

}  // namespace tetrec
