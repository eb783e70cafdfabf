// The constants of one step of Adam, for the kernel and for the CPU.
#pragma once

#include "render/renderer.h"
#include "shared/gpu_types.glsl.h"

#include <cmath>

namespace tetrec {

// Quanta of fixed-point gradients are 1.
inline gpu_types::AdamPush MakeAdamPush(const TrainingStep& step, uint32_t row_count) {
  const AdamOptions& adam = step.adam;
  const double t = step.adam_step;
  const float first_correction = float(1.0 / (1.0 - std::pow(double(adam.beta1), t)));
  return {.row_count = row_count,
          .beta1 = adam.beta1,
          .beta2 = adam.beta2,
          .epsilon = adam.epsilon,
          .color_rate = adam.color_rate * first_correction,
          .density_rate = adam.density_rate * first_correction,
          .second_moment_correction = float(1.0 / (1.0 - std::pow(double(adam.beta2), t))),
          .max_log_density = std::log(adam.max_density),
          .density_decay = adam.density_decay * adam.density_rate,
          .color_quantum = 1.0f,
          .density_quantum = 1.0f};
}

}  // namespace tetrec
