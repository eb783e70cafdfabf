// The update of one row of a field on the CPU, as adam.comp and adam_others.comp make it.
#pragma once

#include "field/field_state.h"
#include "render/adam_push.h"
#include "render/training_renderer.h"
#include "shared/adam.glsl.h"

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

namespace tetrec {

template <class Real>
class RowUpdate {
 public:
  RowUpdate(const AdamUpdate& update, const FieldLayout& layout)
      : layout_(layout),
        attributes_(layout.ByComponent()),
        adam_(MakeAdamPush(update, layout.density(), 0)),
        others_(MakeAdamPush(WithoutMomentum(update), layout.density(), 0)) {}

  // `gradient`: dL/dparameter of each component.
  void Apply(FieldState& state, size_t row, std::span<const Real> gradient,
             const RowRates& rates) const {
    for (size_t c = 0; c < kStandardComponents; ++c) ApplyAdam(state, row, c, gradient, rates);
    size_t begin = kStandardComponents;
    for (size_t i = 2; i < layout_.attributes.size(); ++i) {
      ApplyToOther(state, row, i, begin, gradient, Real(rates.share));
      begin += size_t(layout_.attributes[i].components);
    }
  }

 private:
  void ApplyAdam(FieldState& state, size_t row, size_t c, std::span<const Real> gradient,
                 const RowRates& of_row) const {
    const Real share(of_row.share);
    const AdamRates<Real> rates{Real(adam_.beta1), Real(adam_.beta2), Real(adam_.epsilon),
                                Real(adam_.second_moment_correction)};
    float& parameter = state.parameters[row * attributes_.size() + c];
    float& first = state.first_moment[row * size_t(FieldLayout::FirstMoments()) + c];
    float& second = state.second_moment[row * size_t(layout_.SecondMoments()) + c];
    AdamState<Real> next =
        AdamStep(AdamState<Real>{Real(parameter), Real(first), Real(second)}, rates,
                 share * Real(adam_.rates[int(attributes_[c]->rate)]), gradient[c]);
    const bool is_density = c == kDensityOffset;
    if (is_density && IsSeen(gradient)) {
      next.parameter = DecayedDensity(next.parameter, share * Real(adam_.density_decay),
                                      Real(ParameterOf(*attributes_[c], of_row.kept_density)));
    }
    Real least(adam_.least_density);
    if (is_density) {
      least = std::max(least, Real(ParameterOf(*attributes_[c], of_row.least_density)));
    }
    next.parameter = ClampParameter(int(attributes_[c]->activation), next.parameter, least,
                                    Real(adam_.largest_density));
    if (attributes_[c]->activation == Activation::kSigned) {
      next = StopAtZero(next, Real(parameter));
    }
    parameter = float(next.parameter);
    first = float(next.first);
    second = float(next.second);
  }

  static bool IsSeen(std::span<const Real> gradient) {
    for (size_t c = 0; c < kStandardComponents; ++c) {
      if (gradient[c] != Real(0)) return true;
    }
    return false;
  }

  // Updates attribute `number`, whose components begin at `begin`.
  void ApplyToOther(FieldState& state, size_t row, size_t number, size_t begin,
                    std::span<const Real> gradient, Real share) const {
    const Attribute& attribute = layout_.attributes[number];
    const size_t end = begin + size_t(attribute.components);
    Real squares(0);
    for (size_t c = begin; c < end; ++c) squares += gradient[c] * gradient[c];
    if (squares == Real(0)) return;
    float& second = state.second_moment[row * size_t(layout_.SecondMoments()) +
                                        size_t(kStandardComponents) + number - 2];
    const Real moment =
        SharedMoment(Real(second), squares / Real(attribute.components), Real(others_.beta2));
    const Real rate =
        SharedRate(share * Real(others_.rates[int(attribute.rate)]), moment, Real(others_.epsilon));
    const Real decay =
        attribute.rate == RateClass::kHarmonics ? share * Real(others_.harmonics_decay) : Real(0);
    second = float(moment);
    for (size_t c = begin; c < end; ++c) {
      float& parameter = state.parameters[row * attributes_.size() + c];
      parameter = float(ClampParameter(int(attribute.activation),
                                       SharedStep(Real(parameter), decay, rate, gradient[c]),
                                       Real(others_.least_log), Real(others_.largest_log)));
    }
  }

  const FieldLayout& layout_;
  std::vector<const Attribute*> attributes_;
  gpu_types::AdamPush adam_, others_;
};

}  // namespace tetrec
