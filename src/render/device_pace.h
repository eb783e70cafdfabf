// What keeps a device busy, and how fast it then is.
#pragma once

#include <cstddef>
#include <cstdint>

namespace tetrec {

// The defaults are those of two CPU cores.
struct DevicePace {
  int rays_per_step = 4096;
  // If colours depend on the view, renderers compute them for each view of a batch: the fewer, the
  // less work and memory. A batch may have more than this, but memory is set aside for no more.
  size_t views_per_batch = 4;
  double speed = 1;  // rays per second that a run can count on, as a multiple of two cores'
  // From one motion of vertices to the next. The host's part of a motion takes as long as several
  // steps.
  uint64_t steps_per_motion = 16;

  bool operator==(const DevicePace&) const = default;
};

}  // namespace tetrec
