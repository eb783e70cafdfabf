// One step of Adam (Kingma and Ba 2015) on one parameter.
#ifndef TETREC_ADAM_GLSL_H_
#define TETREC_ADAM_GLSL_H_

#ifdef __cplusplus
#include "shared/activation.glsl.h"
#include "shared/glsl_subset.h"
#else
#include "activation.glsl.h"
#include "glsl_subset.h"
#endif

TETREC_BEGIN

TETREC_STRUCT AdamState { Real parameter, first, second; };

TETREC_STRUCT AdamRates {
  Real beta1, beta2, epsilon;
  Real second_moment_correction;  // 1 / (1 - beta2^t)
};

// `rate` holds the correction of the first moment, 1 / (1 - beta1^t).
TETREC_FN TETREC_T(AdamState)
    AdamStep(TETREC_T(AdamState) state, TETREC_T(AdamRates) rates, Real rate, Real gradient) {
  TETREC_T(AdamState) next;
  next.first = rates.beta1 * state.first + (Real(1.0) - rates.beta1) * gradient;
  next.second = rates.beta2 * state.second + (Real(1.0) - rates.beta2) * gradient * gradient;
  next.parameter =
      state.parameter -
      rate * next.first / (sqrt(next.second * rates.second_moment_correction) + rates.epsilon);
  return next;
}

// Attributes behind colour and density have long rows, of which few have gradients in a step. So
// they are learned without momentum, as by RMSprop, and all components of a row share one second
// moment; a row without gradients stays as it is. The moment begins as the first mean square. A row
// that only faint rays had passed makes a step of up to 1 / sqrt(1 - beta2) times the rate when a
// ray gives it its full weight; a bound on that gained nothing.
TETREC_FN Real SharedMoment(Real before, Real mean_square, Real beta2) {
  return before > Real(0.0) ? beta2 * before + (Real(1.0) - beta2) * mean_square : mean_square;
}

// What the gradients of such a row are multiplied by to make its step. `rate` has no correction.
TETREC_FN Real SharedRate(Real rate, Real moment, Real epsilon) {
  return rate / (sqrt(moment) + epsilon);
}

// Such a parameter after its step, with a share `decay` removed besides what the gradient asks for
// (Loshchilov and Hutter 2019, "Decoupled weight decay regularization").
TETREC_FN Real SharedStep(Real parameter, Real decay, Real rate, Real gradient) {
  return parameter - (decay * parameter + rate * gradient);
}

// Density's parameter with `decay` removed, unless it is `kept` or more.
TETREC_FN Real DecayedDensity(Real parameter, Real decay, Real kept) {
  return parameter < kept ? parameter - decay : parameter;
}

// Lets a signed parameter that falls through 0 stop there once, without its momentum: below 0 most
// rays no longer move it, so it should not get there by what others have changed since.
TETREC_FN TETREC_T(AdamState) StopAtZero(TETREC_T(AdamState) next, Real before) {
  if (before > Real(0.0) && next.parameter <= Real(0.0)) {
    next.parameter = Real(0.0);
    next.first = Real(0.0);
  }
  return next;
}

// Colour stays in the pictures' range.
TETREC_FN Real ClampColor(Real color) {
  return color < Real(0.0) ? Real(0.0) : color > Real(1.0) ? Real(1.0) : color;
}

// Bounds of a parameter (BoundsOf of field/layout.h, and a row's own). The upper one counts if
// they contradict each other.
TETREC_FN Real ClampBetween(Real parameter, Real least, Real largest) {
  Real raised = parameter < least ? least : parameter;
  return raised > largest ? largest : raised;
}

// What an update leaves of a parameter, by its activation.
TETREC_FN Real ClampParameter(int activation, Real parameter, Real least, Real largest) {
  if (activation == kActivationColor) return ClampColor(parameter);
  if (activation == kActivationIdentity) return parameter;
  return ClampBetween(parameter, least, largest);
}

TETREC_END

#endif  // TETREC_ADAM_GLSL_H_
