// The constants of one step of Adam, for the kernel and for the CPU.
#pragma once

#include "render/training_renderer.h"
#include "shared/adam.glsl.h"
#include "shared/gpu_types.glsl.h"

#include <cmath>

namespace tetrec {

static_assert(uint32_t(RateClass::kColor) == kRateColor &&
              uint32_t(RateClass::kDensity) == kRateDensity &&
              uint32_t(RateClass::kHarmonics) == kRateHarmonics && kRateClasses <= 4);

// For attributes that are learned without it: their rates have no correction.
inline AdamUpdate WithoutMomentum(AdamUpdate update) {
  update.beta1 = 0;
  return update;
}

// The share by which coefficients of view-dependent colour decay in one step.
inline float HarmonicsDecayOfStep(const AdamUpdate& update) {
  return float(update.harmonics_decay) * float(update.harmonics_rate);
}

// Quanta of fixed-point gradients are 1.
inline gpu_types::AdamPush MakeAdamPush(const AdamUpdate& update, const Attribute& density,
                                        uint32_t row_count) {
  const double t = update.step;
  const float first_correction = float(1.0 / (1.0 - std::pow(double(update.beta1), t)));
  glm::vec4 rates(0.0f);
  rates[kRateColor] = float(update.color_rate) * first_correction;
  rates[kRateDensity] = float(update.density_rate) * first_correction;
  rates[kRateHarmonics] = float(update.harmonics_rate) * first_correction;
  const ParameterBounds logs = BoundsOf(kDensityAttribute, float(update.max_density));
  const ParameterBounds bounds = BoundsOf(density, float(update.max_density));
  return {.rates = rates,
          .quanta = glm::vec4(1.0f),
          .row_count = row_count,
          .beta1 = update.beta1,
          .beta2 = update.beta2,
          .epsilon = update.epsilon,
          .second_moment_correction = float(1.0 / (1.0 - std::pow(double(update.beta2), t))),
          .least_log = logs.least,
          .largest_log = logs.largest,
          .least_density = bounds.least,
          .largest_density = bounds.largest,
          .density_scale = density.scale,
          .density_decay = float(update.density_decay) * float(update.density_rate),
          .harmonics_decay = HarmonicsDecayOfStep(update)};
}

}  // namespace tetrec
