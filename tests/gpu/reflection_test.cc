// What is read from the SPIR-V of kernels, sound and damaged.
#include "gpu/reflection.h"

#include "core/error.h"
#include "embedded_shaders.h"
#include "shared/gpu_types.glsl.h"
#include "test_shaders.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace tetrec::test {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::FieldsAre;
using ::testing::HasSubstr;

// number, access, is_used, name
auto Is(uint32_t number, Access access, bool is_used, const char* name) {
  return FieldsAre(number, access, is_used, name);
}

TEST(ReflectionTest, BackwardMarchWithPositions) {
  const Reflection march = Reflect("march", kMarchBackwardPositionsFixed);
  EXPECT_THAT(march.bindings,
              ElementsAre(Is(kBindTets, Access::kTexelRead, true, "tets"),
                          Is(kBindVertices, Access::kTexelRead, true, "vertices"),
                          Is(kBindHull, Access::kTexelRead, true, "hull"),
                          Is(kBindViews, Access::kTexelRead, true, "views"),
                          Is(kBindBlocks, Access::kTexelRead, true, "blocks"),
                          Is(kBindRayColors, Access::kRead, true, "RayColors"),
                          Is(kBindRayEntries, Access::kRead, true, "RayEntries"),
                          Is(kBindRayGradients, Access::kRead, true, "RayGradients"),
                          Is(kBindVertexGradients, Access::kReadWrite, true, "VertexGradients"),
                          Is(kBindCounters, Access::kReadWrite, true, "Counters"),
                          Is(kBindPositionGradients, Access::kReadWrite, true, "PositionGradients"),
                          Is(kBindColors, Access::kTexelRead, true, "colors")));
  EXPECT_EQ(march.push_bytes, sizeof(gpu_types::MarchPush));
  EXPECT_THAT(march.local_size, ElementsAre(kWorkgroupSize, 1, 1));
  EXPECT_THAT(march.constant_ids, ElementsAre(0, 1, kConstantAnyBoundary, kConstantStorage,
                                              kConstantHarmonics, kConstantAbsoluteSums));
}

// Only fixed-point sums count addends that are too large.
TEST(ReflectionTest, BindingThatAVariantDeclaresButDoesNotUse) {
  const Reflection march = Reflect("march", kMarchBackwardCas);
  EXPECT_THAT(march.bindings, Contains(Is(kBindCounters, Access::kReadWrite, false, "Counters")));
}

TEST(ReflectionTest, ScatterOfTheRadixSort) {
  const Reflection scatter = Reflect("scatter", kSortScatter);
  EXPECT_THAT(scatter.bindings,
              ElementsAre(Is(kBindKeys, Access::kRead, true, "Keys"),
                          Is(kBindItems, Access::kRead, true, "Items"),
                          Is(kBindSortedKeys, Access::kWrite, true, "SortedKeys"),
                          Is(kBindSortedItems, Access::kWrite, true, "SortedItems"),
                          Is(kBindDigitCounts, Access::kReadWrite, true, "DigitCounts")));
  EXPECT_THAT(scatter.constant_ids, ElementsAre());
}

TEST(ReflectionTest, TwoStagesTogether) {
  const Reflection faces =
      Merge("faces", Reflect("vertex", kPpllFacesVertex), Reflect("fragment", kPpllFacesFragment));
  EXPECT_THAT(faces.bindings, ElementsAre(Is(kBindTets, Access::kTexelRead, true, "tets"),
                                          Is(kBindVertices, Access::kTexelRead, true, "vertices"),
                                          Is(kBindViews, Access::kTexelRead, true, "views"),
                                          Is(kBindBlocks, Access::kTexelRead, true, "blocks"),
                                          Is(kBindCounters, Access::kReadWrite, true, "Counters"),
                                          Is(kBindFaces, Access::kRead, true, "Faces"),
                                          Is(kBindLists, Access::kRead, true, "Lists"),
                                          Is(kBindListFills, Access::kReadWrite, true, "ListFills"),
                                          Is(kBindFragments, Access::kWrite, true, "Fragments"),
                                          Is(kBindFaceChunks, Access::kRead, true, "FaceChunks"),
                                          Is(kBindAppended, Access::kWrite, true, "Appended"),
                                          Is(kBindColors, Access::kTexelRead, false, "colors")));
  EXPECT_EQ(faces.push_bytes, sizeof(gpu_types::PpllPush));
}

TEST(ReflectionTest, StagesThatReadAndWriteABindingAreReadWriteTogether) {
  Reflection reads, writes, texels;
  reads.bindings = {{3, Access::kRead, false, "a"}};
  writes.bindings = {{1, Access::kRead, true, "b"}, {3, Access::kWrite, true, "a"}};
  texels.bindings = {{3, Access::kTexelRead, true, "a"}};
  EXPECT_THAT(Merge("both", reads, writes).bindings,
              ElementsAre(Is(1, Access::kRead, true, "b"), Is(3, Access::kReadWrite, true, "a")));
  EXPECT_THROW(Merge("both", reads, texels), BugError);
}

// The same structs, laid out by the shader compiler and by C++.
TEST(ReflectionTest, PushConstantsAreAsLargeAsOnTheHost) {
  EXPECT_EQ(Reflect("adam", kAdam).push_bytes, sizeof(gpu_types::AdamPush));
  EXPECT_EQ(Reflect("loss", kLoss).push_bytes, sizeof(gpu_types::LossPush));
  EXPECT_EQ(Reflect("dssim", kDssimRows).push_bytes, sizeof(gpu_types::DssimPush));
  EXPECT_EQ(Reflect("scan", kScanSums).push_bytes, sizeof(gpu_types::ScanPush));
  EXPECT_EQ(Reflect("sort", kSortCount).push_bytes, sizeof(gpu_types::SortPush));
  EXPECT_EQ(Reflect("spread", kSpread).push_bytes, sizeof(gpu_types::SpreadPush));
  EXPECT_EQ(Reflect("projection", kProjectionForward).push_bytes,
            sizeof(gpu_types::ProjectionPush));
  EXPECT_EQ(Reflect("stairs", kStairsvert).push_bytes, 0u);
}

// A module that is cut off may still read as a shorter one; it never reads beyond its end.
TEST(ReflectionTest, CutOffModulesAreBugsOrShorter) {
  const std::span<const uint32_t> whole = kSortScatter;
  size_t refused = 0;
  for (size_t words = 0; words < whole.size(); ++words) {
    const std::vector<uint32_t> part(whole.begin(), whole.begin() + words);
    try {
      Reflect("part", part);
    } catch (const BugError& error) {
      EXPECT_THAT(error.what(), HasSubstr("kernel part: "));
      ++refused;
    }
  }
  EXPECT_GT(refused, whole.size() / 2);
}

TEST(ReflectionTest, DamagedModulesAreReadOrRefused) {
  std::mt19937 random(9);
  const std::span<const uint32_t> whole = kSortScatter;
  for (int round = 0; round < 5'000; ++round) {
    std::vector<uint32_t> damaged(whole.begin(), whole.end());
    for (int i = 0; i < 3; ++i) {
      const uint32_t word = uint32_t(random() % 2 == 0 ? random() : random() % 400);
      damaged[random() % damaged.size()] = word;
    }
    try {
      Reflect("damaged", damaged);
    } catch (const BugError&) {
    }
  }
}

TEST(ReflectionTest, WordsThatAreNotSpirvAreABug) {
  EXPECT_THROW(Reflect("nothing", {}), BugError);
  const uint32_t words[] = {0x03022307, 0x10600, 0, 10, 0};  // the magic number in the other order
  EXPECT_THROW(Reflect("swapped", words), BugError);
  for (uint32_t op : {5u, 15u, 16u, 32u, 43u, 59u, 71u, 72u}) {  // instructions without operands
    const uint32_t bare[] = {0x07230203, 0x10600, 0, 10, 0, 1u << 16 | op};
    EXPECT_THROW(Reflect("bare", bare), BugError) << op;
  }
}

}  // namespace
}  // namespace tetrec::test
