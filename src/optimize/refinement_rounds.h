// The rounds of refinement of a run: when one is due, what it does, and the return to the best
// field if the judging pictures lost by it.
#pragma once

#include "optimize/batches.h"
#include "optimize/fitted_field.h"
#include "optimize/mesh_budget.h"
#include "optimize/optimize_options.h"
#include "optimize/training_pictures.h"
#include "optimize/training_steps.h"
#include "optimize/vertex_motion.h"
#include "render/training_renderer.h"
#include "run/mesh_growth.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

namespace tetrec {

// The record of a mesh that nothing has judged yet.
GrowthStep StepOf(double seconds, uint64_t iteration, const TetMesh& mesh);

// What a resumed run needs.
struct RoundsState {
  uint32_t rounds = 0;               // done
  uint32_t ended = 0;                // 1: the mesh is refined no more
  uint64_t settled = 0;              // the last iteration at which the field settled to be judged
  double best_psnr = 0;              // of the judging pictures, before a round [dB]
  std::vector<ErrorSum> last_views;  // what they said before the last round
  std::vector<GrowthStep> steps;     // one for each time that was decided about the mesh
  bool operator==(const RoundsState&) const = default;
};

// What a round works on.
struct RefinedParts {
  FittedField& field;
  VertexMotion& motion;
  TrainingPictures& pictures;
  BatchDrawer& batches;
  TrainingSteps& steps;
  TrainingRenderer& renderer;
};

// Fields that wait on disk.
struct RoundsFiles {
  std::filesystem::path best;
  std::filesystem::path unrefined;       // while a refinement may turn out too large for the budget
  std::filesystem::path coarser, finer;  // while the other one learns
};

class RefinementRounds {
 public:
  // The mesh never exceeds `max_tets`.
  RefinementRounds(const OptimizeOptions& options, std::vector<PlannedRound> plan,
                   const RefinedParts& parts, RoundsFiles files, uint64_t max_tets = kNoBudget);

  // Once steps() has been resumed.
  void Resume(RoundsState state);
  const RoundsState& state() const { return state_; }

  // At this growth of the run.
  bool IsDue(double growth) const;
  // True if the mesh is refined no more.
  bool IsOver() const { return state_.ended != 0 || state_.rounds >= plan_.size(); }
  // True in a long run, whose last rounds come after the growth of a short one.
  bool HasLateRounds() const { return !plan_.empty() && plan_.back().is_late; }
  // True if the next round, which is due, is a trial.
  bool NeedsTrial() const;
  // Where the noise of high learning rates may hide that the judging pictures are matched, takes
  // some steps that settle the field; the round is then still due. Otherwise refines the mesh. If
  // the judging pictures clearly lost since the round before, the run returns to the field before
  // that one and refines no more; nor does it once growth has gained no more than the standard
  // error, by one late round or by two rounds in a row, or once the judging pictures are matched,
  // unless the options ask for all. A late round stays only if the finer mesh then gains more than
  // the standard error over the mesh before, once each has learned as long. A round that comes so
  // late that the judging pictures are about to be learned, on a machine of few steps per second,
  // is left out with all that follow, because little would be left to learn a finer mesh, and
  // nothing to judge it by. If the run is asked to stop meanwhile, the round is taken back, and is
  // due again. `seconds`: of the run so far, for the record.
  void Advance(double seconds, const RunMoment& moment);
  // An entry about a mesh that another part of the run decided about.
  void Record(const GrowthStep& step) { state_.steps.push_back(step); }
  // The judging pictures gained by something else than the field [dB].
  void RaiseBest(double gain) { state_.best_psnr += gain; }
  // Fields are judged in another way from now on, by which this is the judgement of the field. That
  // field is the best one then, and the next round is compared with it.
  void JudgeAnew(const Judgement& now);

 private:
  bool IsTaught() const;
  bool AsksForAll() const;
  bool ComesTooLate(double progress) const;
  void EndForLackOfTime(GrowthStep step);
  bool MustSettle(const Judgement& now) const;
  bool HasSettled() const;
  void Settle();
  GrowthDecision Decide(const Judgement& now, const JudgedGain& gain) const;
  bool LastRoundGained() const;
  bool IsWorthRefining(const Judgement& now, GrowthStep& step);
  std::optional<RefineResult> RefineWithinBudget(const FieldState& before,
                                                 const RefineScores& scores, RefineOptions refine);
  void SaveBest(double psnr);
  void ReturnToBest(double psnr);
  void RefineOnce();
  bool TryRefining(double seconds, const RunMoment& moment);
  uint64_t StepsOfTrial() const;
  std::optional<Judgement> Learn(uint64_t from, uint64_t steps, const RunMoment& moment);
  bool LearnPart(uint64_t steps, const RunMoment& as_at, const RunMoment& moment);
  void StayCoarser(GrowthStep finer, const Judgement& judgement, const JudgedGain& gain);

  const OptimizeOptions& options_;
  std::vector<PlannedRound> plan_;
  RefinedParts parts_;
  RoundsFiles files_;
  uint64_t max_tets_;
  RoundsState state_;
  uint64_t last_iteration_ = 0;  // at the last round, or when the run was resumed
};

}  // namespace tetrec
