// The version of the programs.
#pragma once

namespace tetrec {

// "0.1.0"
const char* ProgramVersion();
// The revision in git at the time of configuration, "abc1234-dirty"; "unknown" outside a
// repository.
const char* GitRevision();

}  // namespace tetrec
