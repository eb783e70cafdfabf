// The user's request to stop, made by SIGINT or SIGTERM.
#pragma once

#include <string>

namespace tetrec {

// From now on, the first SIGINT or SIGTERM sets a flag and the second one ends the process at once.
// SIGPIPE is ignored: a closed terminal or pipe must not end hours of work.
void CatchStopSignals();

bool StopRequested();

// Throws Interrupted if a stop was requested; `saved` states what is kept, for the message.
void ThrowIfStopRequested(const std::string& saved);

}  // namespace tetrec
