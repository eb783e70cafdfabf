// The D-SSIM part of the loss of a batch of tiles, on the device.
#include "render/vulkan/dssim_loss.h"

#include "core/error.h"
#include "embedded_shaders.h"
#include "shared/ssim.glsl.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

namespace tetrec {

using gpu_types::DssimPush;

namespace {

// One for each channel and ray.
uint64_t ValuesOf(uint64_t rays) { return 3 * rays; }

// Windows of all batches of the mean, which have the same share of them as of its rays.
double WindowsOfMean(const TrainingBatch& step) {
  return double(CountWindows(step)) * (double(step.rays_of_mean()) / double(step.rays()));
}

}  // namespace

double DssimBatch::Mix(double pixel_loss) const {
  if (weight == 0) return pixel_loss;
  const std::vector<float> sums = partial_ssims.DownloadAs<float>(workgroups);
  const double ssim = std::accumulate(sums.begin(), sums.end(), 0.0) / double(windows);
  return (1.0 - weight) * pixel_loss + weight * 0.5 * (1.0 - ssim);
}

DssimLoss::DssimLoss(const Device& device)
    : device_(device),
      rows_(device, "dssim_rows", kDssimRows),
      windows_(device, "dssim_windows", kDssimWindows),
      spread_(device, "dssim_spread", kDssimSpread),
      gradients_(device, "dssim_gradients", kDssimGradients) {}

void DssimLoss::Prepare(DssimBatch& batch, const TrainingBatch& step) const {
  const uint64_t values = ValuesOf(step.rays());
  batch.windows = CountWindows(step);
  batch.workgroups = (values + kWorkgroupSize - 1) / kWorkgroupSize;
  Grow(device_, batch.pictures, "images of tiles", 8 * values);
  Grow(device_, batch.window_rows, "rows of windows", 20 * values);
  Grow(device_, batch.window_terms, "terms of windows", 12 * values);
  Grow(device_, batch.partial_ssims, "partial sums of SSIM", 4 * batch.workgroups,
       BufferHome::kHostReads);
}

void DssimLoss::Record(CommandRecorder& recorder, const DssimBatch& batch, const RayBatch& rays,
                       const TrainingBatch& step, const Buffer& exposures) const {
  const uint64_t values = ValuesOf(rays.count);
  const DssimPush push{.ray_count = rays.count,
                       .tile_columns = step.tiles.columns,
                       .tile_rows = step.tiles.rows,
                       .gradient_scale = float(-0.5 * batch.weight / WindowsOfMean(step)),
                       .background = glm::vec4(step.background_srgb, 0.0f)};
  recorder.Dispatch(rows_, {{kBindPictures, batch.pictures}, {kBindWindowRows, batch.window_rows}},
                    push, values);
  recorder.Dispatch(windows_,
                    {{kBindWindowRows, batch.window_rows},
                     {kBindWindowTerms, batch.window_terms},
                     {kBindPartialSsims, batch.partial_ssims}},
                    push, values);
  recorder.Dispatch(spread_,
                    {{kBindWindowTerms, batch.window_terms}, {kBindWindowRows, batch.window_rows}},
                    push, values);
  recorder.Dispatch(gradients_,
                    {{kBindPictures, batch.pictures},
                     {kBindWindowRows, batch.window_rows},
                     {kBindBlocks, rays.blocks},
                     {kBindExposures, exposures},
                     {kBindRayGradients, rays.gradients}},
                    push, rays.count);
}

uint64_t CountWindows(const TrainingBatch& step) {
  const size_t blocks = size_t(step.tiles.columns) * step.tiles.rows;
  const int columns = int(step.tiles.columns) * kRayBlockWidth - 2 * kSsimReach;
  const int rows = int(step.tiles.rows) * kRayBlockHeight - 2 * kSsimReach;
  TETREC_CHECK(blocks > 0 && step.blocks.size() % blocks == 0 && columns > 0 && rows > 0,
               fmt::format("D-SSIM of {} blocks in tiles of {} x {}", step.blocks.size(),
                           step.tiles.columns, step.tiles.rows));
  return 3 * uint64_t(step.blocks.size() / blocks) * uint64_t(columns) * uint64_t(rows);
}

double GradientScale(const TrainingBatch& step) {
  const double by_pixel = 1.0 / double(3 * step.rays_of_mean());
  if (step.dssim_weight == 0) return by_pixel;
  // In a flat window SSIM changes by up to 1 / sqrt(C2) = 33 per unit of contrast.
  const double by_ssim = 33.0 * 0.5 / WindowsOfMean(step);
  return (1.0 - step.dssim_weight) * by_pixel + step.dssim_weight * by_ssim;
}

}  // namespace tetrec
