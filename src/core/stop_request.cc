// Signal handlers and the flag that they set.
#include "core/stop_request.h"

#include "core/error.h"

#include <unistd.h>

#include <csignal>

namespace tetrec {
namespace {

volatile std::sig_atomic_t stop_signal = 0;

extern "C" void OnStopSignal(int number) {
  if (stop_signal != 0) _exit(130);
  stop_signal = number;
}

}  // namespace

void CatchStopSignals() {
  struct sigaction action {};
  action.sa_handler = OnStopSignal;
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
}

bool StopRequested() { return stop_signal != 0; }

void ThrowIfStopRequested(const std::string& saved) {
  if (StopRequested()) throw Interrupted("stopped by the user; " + saved);
}

}  // namespace tetrec
