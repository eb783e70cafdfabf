// The loss of a batch of tiles with a D-SSIM part, on the device.
#include "render/dssim_loss.h"

#include "core/error.h"
#include "embedded_shaders.h"
#include "shared/ssim.glsl.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

namespace tetrec {

using gpu_types::DssimPush;
using gpu_types::LossPush;

double DssimBatch::Mix(double pixel_loss) const {
  if (weight == 0) return pixel_loss;
  const std::vector<float> sums = partial_ssims.DownloadAs<float>(workgroups);
  const double ssim = std::accumulate(sums.begin(), sums.end(), 0.0) / double(windows);
  return (1.0 - weight) * pixel_loss + weight * 0.5 * (1.0 - ssim);
}

DssimLoss::DssimLoss(const Device& device)
    : device_(device),
      loss_(device, "loss (pictures)", kLossWithPictures,
            {{kBindViews, Access::kTexelRead},
             {kBindBlocks, Access::kTexelRead},
             {kBindRayColors, Access::kRead},
             {kBindRayGradients, Access::kWrite},
             {kBindPartialLosses, Access::kWrite},
             {kBindTargets, Access::kTexelRead},
             {kBindPictures, Access::kWrite}},
            sizeof(LossPush)),
      rows_(device, "dssim_rows", kDssimRows,
            {{kBindPictures, Access::kRead}, {kBindWindowRows, Access::kWrite}}, sizeof(DssimPush)),
      windows_(device, "dssim_windows", kDssimWindows,
               {{kBindWindowRows, Access::kRead},
                {kBindWindowTerms, Access::kWrite},
                {kBindPartialSsims, Access::kWrite}},
               sizeof(DssimPush)),
      spread_(device, "dssim_spread", kDssimSpread,
              {{kBindWindowTerms, Access::kRead}, {kBindWindowRows, Access::kWrite}},
              sizeof(DssimPush)),
      gradients_(device, "dssim_gradients", kDssimGradients,
                 {{kBindPictures, Access::kRead},
                  {kBindWindowRows, Access::kRead},
                  {kBindRayGradients, Access::kReadWrite}},
                 sizeof(DssimPush)) {}

void DssimLoss::Record(CommandRecorder& recorder, DssimBatch& batch, const RayBatch& rays,
                       const TrainingStep& step, LossPush pixel_loss, const Buffer& views,
                       const Buffer& targets) const {
  const uint64_t values = 3 * uint64_t(rays.count);  // a value a channel and ray
  batch.weight = step.dssim_weight;
  batch.windows = CountWindows(step);
  batch.workgroups = (values + kWorkgroupSize - 1) / kWorkgroupSize;
  Grow(device_, batch.pictures, "pictures of tiles", 8 * values);
  Grow(device_, batch.window_rows, "rows of windows", 20 * values);
  Grow(device_, batch.window_terms, "terms of windows", 12 * values);
  Grow(device_, batch.partial_ssims, "partial sums of SSIM", 4 * batch.workgroups);

  pixel_loss.gradient_scale *= 1.0f - step.dssim_weight;
  const Buffer* compared[] = {&views,          &rays.blocks,         &rays.colors,
                              &rays.gradients, &rays.partial_losses, &targets,
                              &batch.pictures};
  recorder.Dispatch(loss_, compared, pixel_loss, rays.count, kWorkgroupSize);
  const DssimPush push{.ray_count = rays.count,
                       .tile_columns = step.tiles.columns,
                       .tile_rows = step.tiles.rows,
                       .gradient_scale = float(-0.5 * batch.weight / double(batch.windows)),
                       .background = pixel_loss.background};
  const Buffer* rows[] = {&batch.pictures, &batch.window_rows};
  recorder.Dispatch(rows_, rows, push, values, kWorkgroupSize);
  const Buffer* windows[] = {&batch.window_rows, &batch.window_terms, &batch.partial_ssims};
  recorder.Dispatch(windows_, windows, push, values, kWorkgroupSize);
  const Buffer* spread[] = {&batch.window_terms, &batch.window_rows};
  recorder.Dispatch(spread_, spread, push, values, kWorkgroupSize);
  const Buffer* gradients[] = {&batch.pictures, &batch.window_rows, &rays.gradients};
  recorder.Dispatch(gradients_, gradients, push, rays.count, kWorkgroupSize);
}

uint64_t CountWindows(const TrainingStep& step) {
  const size_t blocks = size_t(step.tiles.columns) * step.tiles.rows;
  const int columns = int(step.tiles.columns) * kRayBlockWidth - 2 * kSsimReach;
  const int rows = int(step.tiles.rows) * kRayBlockHeight - 2 * kSsimReach;
  TETREC_CHECK(blocks > 0 && step.blocks.size() % blocks == 0 && columns > 0 && rows > 0,
               fmt::format("D-SSIM of {} blocks in tiles of {} x {}", step.blocks.size(),
                           step.tiles.columns, step.tiles.rows));
  return 3 * uint64_t(step.blocks.size() / blocks) * uint64_t(columns) * uint64_t(rows);
}

double GradientScale(const TrainingStep& step) {
  const double by_pixel = 1.0 / double(3 * step.blocks.size() * kRaysPerBlock);
  if (step.dssim_weight == 0) return by_pixel;
  // In a flat window SSIM changes by up to 1 / sqrt(C2) = 33 a unit of contrast.
  const double by_ssim = 33.0 * 0.5 / double(CountWindows(step));
  return (1.0 - step.dssim_weight) * by_pixel + step.dssim_weight * by_ssim;
}

}  // namespace tetrec
