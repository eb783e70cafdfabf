// The schedule of a run, as functions of its progress in [0, 1], of its steps, and of its growth:
// the progress of a run that is as long, but of kGrowthSeconds at most. So a long run begins like a
// short one, and is at any moment near to what a run of that length gives. In a long run growth
// continues beyond 1.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace tetrec {

struct ScheduleOptions {
  std::optional<int> rounds;  // refinements; by default as many as PlanGrowth finds
  double last_round = 0.55;   // progress at the last refinement; the rest settles
  // Share to which the learning rates fall exponentially; by default they fall by steps.
  std::optional<double> final_rate_share;
  double fine_rays = 0.75;  // growth from which pixels may be learned by 2 x 2 rays each
  // Until this progress the judging pictures are kept from learning.
  double last_judging = 0.7;
  // A refinement that loses more than this on the judging pictures, and more than the standard
  // error, is taken back [dB].
  double judged_loss = 0.1;
  // From this PSNR on, an error of 2.6 grey levels of 255 (root mean square), the judging pictures
  // are matched: more vertices are not needed, and fewer are tried [dB] (IsMatched).
  double matched_psnr = 40;
  // Steps before each refinement of a run by time: on a slow machine a round may be due before the
  // mesh is fitted, and a mesh that is not fitted cannot be judged.
  uint64_t min_round_steps = 150;
};

// The length of a run that growth refers to [s], the steps that a second is taken for in runs by
// iterations, and that length in steps.
inline constexpr double kGrowthSeconds = 120, kStepsPerSecond = 40;
inline constexpr double kGrowthSteps = kGrowthSeconds * kStepsPerSecond;

// No run affords more vertices than one per so many pixels that show the subject.
inline constexpr double kPixelsPerVertex = 16;

// Where a run is: its progress, and its growth, which is never less.
struct RunMoment {
  double progress = 0, growth = 0;
};
// The moment of a run that is not long.
constexpr RunMoment AtProgress(double progress) { return {progress, progress}; }

// The learning rates after `steps` steps, as a share of the first ones. They fall with the steps,
// because what is new must still be learned, and in the last quarter of the run fast, so that the
// noise of batches settles. In a long run they fall by half in the last quarter of its growth, too,
// so that the field is, from then on, near to what it would be if the run ended.
double RateShare(const ScheduleOptions& options, const RunMoment& moment, uint64_t steps);

// A round of refinement.
struct PlannedRound {
  double due;         // growth of the run
  uint64_t vertices;  // that it may lead to
  // True for the further rounds of a long run. Time enough has passed before them for the judging
  // pictures to show whether the round before gained anything; early rounds follow each other so
  // quickly that the noise of high learning rates may hide it (0.2 dB on fox from sparse points).
  // Late rounds refine in place where early ones would triangulate anew. Where no more vertices are
  // affordable, those that drop vertices (DropsVertices) move some to where errors are.
  bool is_late = false;
};

// Rounds by equal factors to `growth_vertices`, which follow each other quickly at first, because a
// coarse mesh is fitted fast and cheaply; and in a long run, which lasts `length` times
// kGrowthSeconds, further ones to `max_vertices`, each after the same multiple of the time before
// it. Unless the options give their number, there are 3 to 9 early rounds, enough to multiply the
// vertices by 4/3 each at most where that many suffice: errors that are looked at more often place
// vertices better, but every look takes time. Late rounds are as many as their vertices take, if
// these are 5 % more or more, and at least about one for each factor of 2.24 in time. A given
// number of rounds is spread over the whole run.
std::vector<PlannedRound> PlanGrowth(const ScheduleOptions& options, uint64_t vertices,
                                     uint64_t growth_vertices, uint64_t max_vertices,
                                     double length);

// The growth from `vertices` in a planned round: at least 1, at most 2.5.
double RoundGrowth(const PlannedRound& round, uint64_t vertices);

// The number of vertices that a run can fit, and needs. Measured on two cores: with vertices that
// move, 100 k give lego at 200x200 after 120 s 0.2 dB more than 180 k, and the demo 0.3 dB less but
// a better surface (F-score 0.93 against 0.87). Never more than one per 16 pixels of the subject
// (SubjectPixels): with one per ten, the demo's images gain nothing and its surface breaks up. What
// more time affords is worth 0.4 dB on the demo in 5 minutes, and nothing on fox and lego in 10.
uint64_t AffordableVertices(double seconds, uint64_t subject_pixels);
// The time at which so many are affordable, as far as time decides [s].
double SecondsForVertices(double vertices);

}  // namespace tetrec
