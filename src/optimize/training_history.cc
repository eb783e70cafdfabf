// The course of a run, as it is recorded while it goes on.
#include "optimize/training_history.h"

#include "core/log.h"

#include <fmt/format.h>

#include <cmath>

namespace tetrec {

void StepAverages::Add(const StepResult& result) {
  if (result.squared_error == 0 && result.loss == 0) return;  // nothing was collected
  loss_ += result.loss;
  squared_error_ += result.squared_error;
  ++count_;
}

double StepAverages::Loss() const { return IsEmpty() ? 0 : loss_ / double(count_); }

double StepAverages::Psnr() const {
  return IsEmpty() ? 0 : -10 * std::log10(squared_error_ / double(count_));
}

bool TrainingHistory::IsDue(const RunFigures& now) const {
  if (now.progress - last_row_ >= 0.02) return true;
  return !has_limit_ && double(now.iteration) >= 1.05 * double(last_row_steps_) + 100;
}

void TrainingHistory::Record(const RunFigures& now) {
  if (!IsDue(now)) return;
  last_row_ = now.progress;
  last_row_steps_ = now.iteration;
  log_.Add(Row(now, WatchIfDue(now.progress), "optimise"));
  progress_.Update(has_limit_ ? now.progress : double(now.iteration), DetailOf(now));
  averages_ = {};
}

std::string TrainingHistory::DetailOf(const RunFigures& now) const {
  constexpr double kLeastTime_s = 0.1;  // whose speed is that of the run
  std::string detail = "it " + WithThousands(now.iteration);
  if (now.seconds >= kLeastTime_s) {
    detail += fmt::format("  {:.0f} k rays/s", double(now.rays) / now.seconds / 1000);
  }
  if (!averages_.IsEmpty()) detail += fmt::format("  loss {:.5f}", averages_.Loss());
  if (last_watched_psnr_) detail += fmt::format("  PSNR {:.2f} dB held out", *last_watched_psnr_);
  return detail + fmt::format("  {} tets", WithThousands(now.tets));
}

std::optional<double> TrainingHistory::WatchIfDue(double progress) {
  if (watched_.views.empty() || progress - last_watch_ < 0.1) return std::nullopt;
  last_watch_ = progress;
  last_watched_psnr_ = WatchPsnr(watched_, StrideFor(watched_, kPixelsOfCurve));
  return last_watched_psnr_;
}

std::optional<double> TrainingHistory::End(const RunFigures& now) {
  std::optional<double> psnr;
  if (!watched_.views.empty()) psnr = WatchPsnr(watched_);
  log_.Add(Row(now, psnr, "end"));
  return psnr;
}

TrainingRow TrainingHistory::Row(const RunFigures& now, std::optional<double> heldout_psnr,
                                 const char* phase) const {
  TrainingRow row;
  row.iteration = now.iteration;
  row.seconds = now.seconds;
  row.rays = now.rays;
  if (!averages_.IsEmpty()) {
    row.loss = averages_.Loss();
    row.train_psnr = averages_.Psnr();
  }
  row.heldout_psnr = heldout_psnr;
  row.tets = now.tets;
  row.vertices = now.vertices;
  row.phase = phase;
  if (count_degenerate_) row.degenerate_tets = count_degenerate_();
  return row;
}

}  // namespace tetrec
