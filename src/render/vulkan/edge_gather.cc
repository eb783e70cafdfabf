// The sums of edges on the device, while they are gathered.
#include "render/vulkan/edge_gather.h"

#include "shared/gpu_types.glsl.h"

namespace tetrec {

void EdgeGather::Begin(const Device& device, const MeshEdges& edges, bool fixed_point) {
  edges_ = edges.ends.size();
  fixed_point_ = fixed_point;
  tet_edges_ = MakeBuffer(device, "edges of tets", edges.of_tets);
  const uint64_t bytes = fixed_point ? sizeof(int64_t) : sizeof(float);
  sums_ = Buffer(device, "edge sums", edges_ * kEdgeSums * bytes);
  sums_.FillZero();
}

std::vector<double> EdgeGather::Download() const {
  std::vector<double> values;
  values.reserve(edges_ * kEdgeSums);
  if (fixed_point_) {
    for (const int64_t quanta : sums_.DownloadAs<int64_t>(edges_ * kEdgeSums)) {
      values.push_back(double(quanta) / kScoreQuanta);
    }
  } else {
    for (const float sum : sums_.DownloadAs<float>(edges_ * kEdgeSums)) values.push_back(sum);
  }
  return values;
}

std::vector<EdgeSums> EdgeGather::Take(double radius) {
  const std::vector<double> values = Download();
  std::vector<EdgeSums> edges;
  edges.reserve(edges_);
  for (size_t i = 0; i < values.size(); i += kEdgeSums) {
    edges.push_back({.color = {values[i], values[i + 1], values[i + 2]},
                     .density = radius * values[i + 3],
                     .color_curvature = values[i + 4],
                     .density_curvature = radius * radius * values[i + 5]});
  }
  tet_edges_ = {};
  sums_ = {};
  return edges;
}

}  // namespace tetrec
