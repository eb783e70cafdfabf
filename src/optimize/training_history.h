// The course of a run, as it is recorded while it goes on: rows of metrics.csv and lines of
// progress, with the PSNR of the watched views.
#pragma once

#include "core/progress.h"
#include "optimize/watch.h"
#include "render/training_renderer.h"
#include "run/training_log.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>

namespace tetrec {

// Where a run is.
struct RunFigures {
  double progress = 0;  // in [0, 1]
  double seconds = 0;   // of optimisation
  uint64_t iteration = 0, rays = 0;
  uint64_t tets = 0, vertices = 0;
};

// Means over the steps since the last row.
class StepAverages {
 public:
  void Add(const StepResult& result);
  bool IsEmpty() const { return count_ == 0; }
  double Loss() const;  // 0 if empty, like Psnr
  double Psnr() const;  // of the training pictures [dB]

 private:
  double loss_ = 0, squared_error_ = 0;
  uint64_t count_ = 0;
};

// All pixels of large photos would take a fifth of a run of two minutes.
inline constexpr uint64_t kPixelsOfCurve = 40000;

class TrainingHistory {
 public:
  // `keep_bytes`: TrainingLogWriter. `has_limit`: the length of the run is known.
  // `count_degenerate`: of the tets, for each row; if there is one, moves may make such.
  TrainingHistory(const std::filesystem::path& path, uint64_t keep_bytes,
                  const WatchedViews& watched, bool has_limit,
                  std::function<uint64_t()> count_degenerate = {})
      : watched_(watched),
        has_limit_(has_limit),
        count_degenerate_(std::move(count_degenerate)),
        log_(path, keep_bytes),
        progress_("optimise", has_limit ? Progress::kShare : 0) {}

  void Add(const StepResult& result) { averages_.Add(result); }
  // A row and a line if 2 % of the run have passed since the last one or, if its length is not
  // known, whenever it has become longer by 5 %.
  void Record(const RunFigures& now);
  // The last row. Returns the PSNR of all pixels of the watched views [dB], if there are any.
  std::optional<double> End(const RunFigures& now);

  uint64_t bytes() const { return log_.bytes(); }  // of metrics.csv

 private:
  // Judges the watched views, by kPixelsOfCurve of their pixels, if 10 % of the run have passed
  // since that was done.
  std::optional<double> WatchIfDue(double progress);
  TrainingRow Row(const RunFigures& now, std::optional<double> heldout_psnr,
                  const char* phase) const;

  // For the line of progress: what is known by now.
  std::string DetailOf(const RunFigures& now) const;

  bool IsDue(const RunFigures& now) const;

  const WatchedViews& watched_;
  bool has_limit_;
  std::function<uint64_t()> count_degenerate_;
  TrainingLogWriter log_;
  Progress progress_;
  StepAverages averages_;
  double last_row_ = -1, last_watch_ = 0;  // their progress
  uint64_t last_row_steps_ = 0;
  std::optional<double> last_watched_psnr_;
};

}  // namespace tetrec
