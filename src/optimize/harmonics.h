// View-dependent colour in training: when degrees of harmonics are unlocked, and which of them
// stay.
#pragma once

#include "core/words.h"
#include "field/field_state.h"
#include "optimize/photo_sight.h"

#include <cstddef>
#include <cstdint>

namespace tetrec {

// The degree up to which colours depend on the view.
enum class HarmonicsChoice {
  kNone,
  kDegree1,
  kDegree2,
  kDegree3,
  kAuto,  // as many degrees as pay (IsJudged) and as the photos determine (HighestDegree)
};
template <>
inline constexpr auto kWords<HarmonicsChoice> =
    std::to_array<Word<HarmonicsChoice>>({{HarmonicsChoice::kAuto, "auto"},
                                          {HarmonicsChoice::kNone, "0"},
                                          {HarmonicsChoice::kDegree1, "1"},
                                          {HarmonicsChoice::kDegree2, "2"},
                                          {HarmonicsChoice::kDegree3, "3"}});

struct HarmonicsState {
  uint32_t unlocked = 0;  // degrees so far
  uint32_t judged = 0;    // of them
  uint32_t closed = 0;    // 1: nothing more is unlocked
  bool operator==(const HarmonicsState&) const = default;
};

// The training photos that determine the coefficients of harmonics up to this degree: as many as
// there are functions of the view.
size_t PhotosForDegree(uint32_t degree);

// The degree that a run may reach; with kAuto, as far as the photos determine it (PhotosForDegree).
uint32_t HighestDegree(HarmonicsChoice choice, size_t photos);

// With kAuto, the judging pictures decide whether degrees 1 and 2 stay. Degree 3 is added once
// degree 2 stays, without a judgement: a short trial shows little of what it gains by the end of a
// run.
bool IsJudged(uint32_t degree);

// What is due at a growth of the run (schedule.h).
enum class HarmonicsStep { kNone, kUnlock, kJudge };
HarmonicsStep NextHarmonicsStep(HarmonicsChoice choice, size_t photos, const HarmonicsState& state,
                                double growth);

// A degree stays if the judging pictures gain more than 0.05 dB by it, and if their mean squared
// error falls by more than one step of 8 bits, squared. `with` and `without`: their PSNR [dB].
bool IsWorthHarmonics(double with, double without);

// A degree that the judging pictures miss as soon as it is taken away stays. For any other, the
// field is trained on with it and without it for TrialSteps, because colours that replace it must
// first become the means of what they were from all sides, and the coefficients of a degree are
// noisy soon after it was unlocked.

// The state without its highest degree, whose mean over the photos that see a place, or over all if
// none does, goes to the colour there.
FieldState WithoutHighestDegree(const TetMesh& mesh, const FieldState& state,
                                const PhotoSight& sight);

}  // namespace tetrec
