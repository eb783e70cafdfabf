// Free memory of the host.
#include "core/free_memory.h"

#include <gtest/gtest.h>

#include <limits>

namespace tetrec {
namespace {

TEST(MeasureFreeHostMemory, IsWhatThisProcessCouldStillAllocate) {
  const FreeMemory free = MeasureFreeHostMemory();
  EXPECT_EQ(free.of, "the host");
  EXPECT_GT(free.bytes, uint64_t{1} << 20);
  EXPECT_LT(free.bytes, std::numeric_limits<uint64_t>::max());
}

}  // namespace
}  // namespace tetrec
