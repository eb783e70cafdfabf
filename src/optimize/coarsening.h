// Coarsening once the mesh has grown: it keeps no more vertices than the pictures need.
#pragma once

#include "optimize/field_on_disk.h"
#include "optimize/judging.h"
#include "optimize/optimize_options.h"
#include "optimize/refinement_rounds.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

namespace tetrec {

// What a resumed run needs.
struct CoarseningState {
  uint32_t ended = 0;            // 1: the mesh stays as it is
  uint32_t has_failed = 0;       // 1: a trial has
  double kept_share = 0.5;       // of the vertices, in the next trial
  uint64_t finest_vertices = 0;  // of the mesh that has grown
  // The errors of the judging pictures with the best mesh so far; empty until it has been judged.
  std::vector<ErrorSum> reference;
  bool operator==(const CoarseningState&) const = default;
};

// True if a trial that keeps a larger share of the vertices than a failed one is expected to fail,
// too: if what it loses is in proportion to what it drops. (It loses rather less than that, because
// the least needed vertices go first.)
bool IsExpectedToFail(const JudgedGain& failed, double kept_share, double milder_share);

// True if the last planned round has been done, the round before it had added vertices, the judging
// pictures then gained clearly more than the standard error, and they were far from matched.
// Dropping half of the vertices would then nearly always lose: it did in 18 of 19 trials
// (tests/bench/schedule.md).
bool StillGains(const RoundsState& rounds, double matched_psnr);

// A trial drops the least needed vertices (spare_vertices.h), learns some steps and judges. If the
// pictures are matched (ScheduleOptions::matched_psnr), or lose no more than the standard error
// against the best mesh so far, the finer one after as many steps included, the coarser mesh stays,
// and otherwise the finer one. The first trial keeps a half of the vertices, and each further one
// the square of the share before, down to a sixteenth, until one fails; then shares become milder,
// until they are not worth a trial, or expected to fail while the pictures are not matched.
class Coarsening {
 public:
  // Trials are recorded with the rounds. The files keep fields that wait while others learn.
  Coarsening(const OptimizeOptions& options, const RefinedParts& parts, RefinementRounds& rounds,
             const std::filesystem::path& finer_file, const std::filesystem::path& coarser_file);

  void Resume(CoarseningState state) { state_ = std::move(state); }
  // Fields are judged in another way from now on: the mesh as it is must be judged again.
  void JudgeAnew() { state_.reference.clear(); }
  const CoarseningState& state() const { return state_; }

  // True if the mesh is coarsened no more. A mesh whose rounds are given is never coarsened, nor is
  // one that grows in full, nor where it is not known which vertices are needed.
  bool IsOver() const { return state_.ended != 0 || !is_wanted_; }
  // Once the rounds are over, and what they inserted has been learned, while pictures judge.
  bool IsDue(double progress) const;
  // Judges the mesh as it is, the first time; then makes one trial. A short run whose mesh still
  // gains (StillGains) has better uses for the steps of a trial: there it makes none. If the run is
  // asked to stop meanwhile, all is as before, and the trial is due again. No gradients may wait
  // for a motion (VertexMotion::CanResumeAfter): they are lost. `seconds`: of the run so far, for
  // the record. Returns whether the mesh has become coarser.
  bool Advance(double seconds, const RunMoment& moment);

 private:
  uint64_t StepsOfTrial() const;
  WaitingField Save(const std::filesystem::path& file) const;
  void PutBack(const WaitingField& waiting);
  bool LookAtFinest(const RunMoment& moment);
  std::optional<bool> TryCoarser(const WaitingField& finer, double seconds,
                                 const RunMoment& moment);
  void ChooseNextShare(bool stays, std::span<const ErrorSum> views);
  bool DropLeastNeeded();
  bool IsAsGood(std::span<const ErrorSum> views) const;
  void RaiseReference(std::vector<ErrorSum> views);
  std::optional<bool> FinerLearnsMore(const WaitingField& finer, std::span<const ErrorSum> coarser,
                                      uint64_t steps, const RunMoment& moment);
  void Record(GrowthStep step, const Judgement& judgement, bool stays);

  const OptimizeOptions& options_;
  RefinedParts parts_;
  RefinementRounds& rounds_;
  std::filesystem::path finer_file_, coarser_file_;
  bool is_wanted_;
  CoarseningState state_;
};

}  // namespace tetrec
