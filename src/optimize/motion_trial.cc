// The choice whether vertices move in a run.
#include "optimize/motion_trial.h"

#include "core/log.h"

#include <algorithm>
#include <utility>

namespace tetrec {
namespace {

// The gradients of a coarse first field move vertices nowhere useful. Growth of the run
// (schedule.h) at which vertices begin to move where nothing is tried, and at which the trial is
// held.
constexpr double kFirstMotion = 0.05, kTrial = 0.1;
// Only a clear loss keeps vertices where they are: a trial shows only the beginning of the gain. On
// datasets_spec/demo/nerf they lose 0.07 dB in the trial and gain 1.1 dB within 1,000 steps.
constexpr double kLeastGainOfMotion_db = -0.1;
constexpr uint64_t kFewestMotions = 3;  // of a trial

}  // namespace

MotionTrial::MotionTrial(const OptimizeOptions& options, FittedField& field,
                         TrainingPictures& pictures, TrainingSteps& steps, VertexMotion& motion)
    : options_(options), field_(field), pictures_(pictures), steps_(steps), motion_(motion) {
  if (options.move == MoveChoice::kOff) Decide(false);
  if (options.move == MoveChoice::kArticle) Decide(true);
}

void MotionTrial::Resume(TrialState state) {
  if (state != TrialState::kNotTried) Decide(state == TrialState::kUsed);
}

void MotionTrial::Decide(bool moves) {
  state_ = moves ? TrialState::kUsed : TrialState::kNotUsed;
  motion_.Use(moves);
}

bool MotionTrial::Advance(const RunMoment& moment) {
  if (state_ != TrialState::kNotTried || moment.growth < kFirstMotion) return false;
  if (options_.move == MoveChoice::kSafe || pictures_.learns_all()) {
    Decide(true);
    return false;
  }
  if (moment.growth < kTrial) return false;
  if (steps_.iteration() < kFewestTrialSteps) return false;
  const uint64_t steps = StepsOfTrial();
  TetMesh mesh = field_.mesh();
  const FieldState before = field_.ReadState();
  const double still = TrialPsnr(false, moment);
  field_.PutState(before);
  const double moving = TrialPsnr(true, moment);
  const bool pays = moving > still + kLeastGainOfMotion_db;
  if (pays) {
    steps_.CountTried(steps);
  } else {
    field_.Put(std::move(mesh), before);
    motion_.Resume({});
  }
  LogInfo("judging pictures after {} steps: {:.2f} dB with moving vertices, {:.2f} dB without: {}",
          steps, moving, still, pays ? "they move" : "they stay");
  Decide(pays);
  return true;
}

// Where motions are rare, the trial takes longer, and ends with one.
uint64_t MotionTrial::StepsOfTrial() const {
  const uint64_t steps = TrialSteps(steps_.iteration()), period = motion_.StepsOfMotion();
  if (period <= kMostSummedBatches) return steps;
  return motion_.StepsToAMotion(steps_.iteration(), std::max(steps, kFewestMotions * period));
}

void MotionTrial::LetCoarserMeshMove() {
  if (options_.move == MoveChoice::kAuto) Decide(true);
}

double MotionTrial::TrialPsnr(bool moves, const RunMoment& moment) {
  motion_.Use(moves);
  steps_.Try(StepsOfTrial(), kRatesOfTrials, moment);
  return pictures_.JudgeField().psnr;
}

}  // namespace tetrec
