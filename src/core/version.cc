// The only file compiled anew when the revision changes.
#include "core/version.h"

namespace tetrec {

const char* ProgramVersion() { return TETREC_VERSION; }

const char* GitRevision() { return TETREC_GIT; }

}  // namespace tetrec
