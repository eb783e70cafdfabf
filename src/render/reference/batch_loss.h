// The loss of a batch, its gradients by the rays, and the sums that exposures are fitted from.
#pragma once

#include "core/error.h"
#include "render/reference/dssim.h"
#include "render/reference/training_targets.h"
#include "shared/loss.glsl.h"
#include "shared/ssim.glsl.h"

#include <glm/glm.hpp>

#include <cmath>
#include <span>
#include <vector>

namespace tetrec {

// As shown_pixels.glsl, for every ray: colour before the background and transmittance of its
// pixel, the means over the pixel's rays. `colors`: colour and optical depth of every ray.
template <class Real>
std::vector<Vec4<Real>> ShownPixels(const BatchRays& batch, std::vector<Vec4<Real>> colors) {
  for (Vec4<Real>& color : colors) color.a = std::exp(-color.a);
  if (batch.samples == 1) return colors;
  TETREC_CHECK(batch.samples == 2, "1 or 2 x 2 rays per pixel");
  std::vector<Vec4<Real>> shown;
  for (size_t ray = 0; ray < colors.size(); ++ray) {
    Vec4<Real> sum(Real(0));
    for (const size_t other : {ray, ray ^ 1, ray ^ kRayBlockWidth, ray ^ (kRayBlockWidth + 1)}) {
      sum += colors[other];
    }
    shown.push_back(Real(0.25) * sum);
  }
  return shown;
}

// As loss.comp: the means of the loss and of the squared error, and of every ray `gradient_scale`
// times the slopes of the loss by the exposed colour and, for the part of alpha_weight, by
// transmittance, 0 outside the image. `shown`: ShownPixels.
template <class Real>
StepResult CompareWithTargets(const TrainingTargets& targets, const BatchRays& batch,
                              std::span<const Vec4<Real>> shown, const TrainingBatch& training,
                              Real gradient_scale, std::span<Vec4<Real>> gradients) {
  const int loss = int(training.loss);
  const Vec3<Real> background(training.background_srgb);
  StepResult result;
  for (size_t i = 0; i < batch.count(); ++i) {
    gradients[i] = Vec4<Real>(Real(0));
    if (!batch.InPicture(i)) continue;
    const Vec4<Real> target = TargetOfRay<Real>(targets, batch, i);
    const ViewExposure& exposure = ExposureOf(targets, batch, i);
    for (int c = 0; c < 3; ++c) {
      const Real residual = ResidualOf(Exposed(exposure, shown[i])[c], shown[i].a, target[c],
                                       target.a, background[c]);
      gradients[i][c] = gradient_scale * LossSlope(loss, residual);
      result.loss += double(LossOf(loss, residual));
      result.squared_error += double(residual) * double(residual);
    }
    const Real weight = Real(training.alpha_weight);
    const Real excess = TransmittanceResidual(shown[i].a, target.r, target.a);
    gradients[i].a = gradient_scale * weight * LossSlope(loss, excess);
    result.loss += double(weight * LossOf(loss, excess));
  }
  result.loss /= 3.0 * double(batch.count());
  result.squared_error /= 3.0 * double(batch.count());
  return result;
}

// Turns dL/d(exposed colour) of every ray, and its dL/dtransmittance by opacity alone, as
// CompareWithTargets leaves them, into dL/d(colour, transmittance).
template <class Real>
void ChainToRays(const TrainingTargets& targets, const BatchRays& batch,
                 const TrainingBatch& training, std::span<Vec4<Real>> gradients) {
  const Vec3<Real> background(training.background_srgb);
  for (size_t i = 0; i < gradients.size(); ++i) {
    const Real by_opacity = gradients[i].a;
    gradients[i] =
        GradientOfRay<Real>(ExposureOf(targets, batch, i), Vec3<Real>(gradients[i]), background);
    gradients[i].a += by_opacity;
  }
}

// Gives D-SSIM its share of the loss and of the rays' gradients, tile by tile.
template <class Real>
void MixDssim(const TrainingTargets& targets, const BatchRays& batch,
              std::span<const Vec4<Real>> shown, const TrainingBatch& training,
              std::span<Vec4<Real>> gradients, StepResult& result) {
  const int width = int(training.tiles.columns) * kRayBlockWidth;
  const int height = int(training.tiles.rows) * kRayBlockHeight;
  const size_t pixels = size_t(width) * size_t(height);
  TETREC_CHECK(batch.samples == 1, "D-SSIM takes one ray per pixel");
  TETREC_CHECK(pixels > 0 && batch.count() % pixels == 0, "D-SSIM needs tiles");
  const glm::dvec3 background(training.background_srgb);
  const double weight = training.dssim_weight;
  const double share = weight * double(pixels) / double(batch.count());
  const double share_of_mean = weight * double(pixels) / double(training.rays_of_mean());
  for (Vec4<Real>& gradient : gradients) gradient *= Real(1.0 - weight);
  result.loss *= 1.0 - weight;
  for (size_t first = 0; first < batch.count(); first += pixels) {
    const glm::ivec2 corner = PixelOfRay(batch.blocks, first);
    const auto place = [&](size_t ray) {
      const glm::ivec2 at = PixelOfRay(batch.blocks, ray) - corner;
      return size_t(at.y) * size_t(width) + size_t(at.x);
    };
    std::vector<glm::dvec3> rendered(pixels), wanted(pixels);
    for (size_t ray = first; ray < first + pixels; ++ray) {
      TETREC_CHECK(batch.InPicture(ray), "a tile of D-SSIM leaves its picture");
      const glm::dvec4 target(TargetOfRay<Real>(targets, batch, ray));
      rendered[place(ray)] = glm::dvec3(Exposed(ExposureOf(targets, batch, ray), shown[ray])) +
                             double(shown[ray].a) * background;
      wanted[place(ray)] = glm::dvec3(target) + (1.0 - target.a) * background;
      if (!IsJudged(target.r, target.a)) {
        rendered[place(ray)] = wanted[place(ray)] = glm::dvec3(kNotJudged);
      }
    }
    const Dssim dssim = EvaluateDssim(rendered, wanted, width, height);
    result.loss += share * dssim.value;
    for (size_t ray = first; ray < first + pixels; ++ray) {
      const glm::dvec3 g = share_of_mean * dssim.gradient[place(ray)];
      gradients[ray] += GradientOfRay<Real>(ExposureOf(targets, batch, ray), Vec3<Real>(g),
                                            Vec3<Real>(background));
    }
  }
}

// As exposure_sums.comp: appends the sums of each block.
template <class Real>
void SumExposures(const TrainingTargets& targets, const BatchRays& batch,
                  std::span<const Vec4<Real>> shown, const TrainingBatch& training,
                  std::vector<BlockExposureSums>& block_sums) {
  for (size_t i = 0; i < batch.count(); ++i) {
    if (i % kRaysPerBlock == 0) block_sums.push_back({batch.IndexOfView(i), {}});
    if (!batch.InPicture(i) || !batch.IsFirstOfPixel(i)) continue;
    const Vec4<Real> target = TargetOfRay<Real>(targets, batch, i);
    if (!IsJudged(target.r, target.a)) continue;
    for (int c = 0; c < 3; ++c) {
      const Real wanted =
          WantedColor(shown[i].a, target[c], target.a, Real(training.background_srgb[c]));
      block_sums.back().sums[size_t(c)].Add(double(shown[i][c]), 1.0 - double(shown[i].a),
                                            double(wanted));
    }
  }
}

}  // namespace tetrec
