// The sums of edges (EdgeSums) on the device, while they are gathered.
#pragma once

#include "gpu/buffer.h"
#include "render/training_renderer.h"

#include <vector>

namespace tetrec {

class EdgeGather {
 public:
  // All sums are zero. `fixed_point`: int64 instead of float.
  void Begin(const Device& device, const MeshEdges& edges, bool fixed_point);
  // Reads the sums and frees the buffers. Kernels count densities in 1 / radius.
  std::vector<EdgeSums> Take(double radius);

  const Buffer& tet_edges() const { return tet_edges_; }
  const Buffer& sums() const { return sums_; }

 private:
  std::vector<double> Download() const;

  Buffer tet_edges_;  // uint, six per tet
  Buffer sums_;       // kEdgeSums per edge
  size_t edges_ = 0;
  bool fixed_point_ = false;
};

}  // namespace tetrec
