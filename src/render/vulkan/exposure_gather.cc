// Exposures of the training views on the device, and the sums that they are fitted from.
#include "render/vulkan/exposure_gather.h"

#include "embedded_shaders.h"

#include <utility>

namespace tetrec {

ExposureGather::ExposureGather(const Device& device)
    : device_(device), program_(device, "exposure_sums", kExposureSums) {}

void ExposureGather::SetExposures(std::span<const ViewExposure> exposures) {
  std::vector<glm::vec4> texels;
  for (const ViewExposure& exposure : exposures) {
    texels.emplace_back(glm::vec3(exposure.gain), 0.0f);
    texels.emplace_back(glm::vec3(exposure.offset), 0.0f);
  }
  views_ = exposures.size();
  exposures_ = MakeBuffer(device_, "exposures", texels, VK_FORMAT_R32G32B32A32_SFLOAT);
}

void ExposureGather::Record(CommandRecorder& recorder, RayBatch& rays,
                            std::span<const RayBlock> blocks, const gpu_types::LossPush& push,
                            const Buffer& views, const Buffer& targets) const {
  Grow(device_, rays.exposure_sums, "exposure sums", blocks.size() * 4 * sizeof(glm::vec4),
       BufferHome::kHostReads);
  recorder.Dispatch(program_,
                    {{kBindViews, views},
                     {kBindBlocks, rays.blocks},
                     {kBindRayColors, rays.colors},
                     {kBindTargets, targets},
                     {kBindExposureSums, rays.exposure_sums}},
                    push, blocks.size());
  for (const RayBlock& block : blocks) rays.summed_views.push_back(block.view);
}

void ExposureGather::Collect(RayBatch& rays) {
  const std::vector<uint32_t> views = std::exchange(rays.summed_views, {});
  const auto rows = rays.exposure_sums.DownloadAs<glm::vec4>(views.size() * 4);
  for (size_t block = 0; block < views.size(); ++block) {
    BlockExposureSums sums{views[block], {}};
    for (size_t c = 0; c < 3; ++c) {
      const glm::dvec4 row(rows[4 * block + c]);
      sums.sums[c] = {double(rows[4 * block + 3].x), row[0], row[1], row[2], row[3]};
    }
    block_sums_.push_back(sums);
  }
}

void ExposureGather::TakeSums(std::span<ExposureSums> sums) {
  AddBlockSums(block_sums_, sums);
  block_sums_.clear();
}

}  // namespace tetrec
