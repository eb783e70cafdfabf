#include "run/mesh_growth.h"

#include "core/error.h"
#include "core/file.h"
#include "expect_error.h"
#include "scratch_folder.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

std::vector<GrowthStep> ExampleGrowth() {
  return {
      {150, 3.5, 1000, 6000, 4000, 300000000, 24.5, 0.0, 0.0, GrowthDecision::kRefine},
      {900, 20.25, 1500, 9100, 3000, 310000000, 26.0, 1.5, 0.125, GrowthDecision::kRefine},
      {2000, 50.0, 2200, 13000, kNotCounted, 320000000, 26.0, 0.0, 0.25,
       GrowthDecision::kFineEnough},
      {2500, 60.0, 2200, 13000, 2600, 320000000, 26.5, 0.5, 0.25, GrowthDecision::kBudget},
      {2600, 62.0, 2200, 13000, kNotCounted, 320000000, 42.5, 16.0, 0.25, GrowthDecision::kMatched},
      {2700, 65.0, 1100, 6500, kNotCounted, 320000000, 42.25, -0.25, 0.25,
       GrowthDecision::kCoarsen},
      {2800, 68.0, 300, 1600, kNotCounted, 320000000, 39.0, -3.5, 0.25, GrowthDecision::kTooCoarse},
      {2900, 72.0, 2900, 17500, kNotCounted, 320000000, 42.0, 0.0, 0.25, GrowthDecision::kTooFine},
      {2950, 76.0, 2200, 13000, kNotCounted, 320000000, 0.0, 0.0, 0.0, GrowthDecision::kTooLate},
      {3000, 80.0, 2200, 13000, 2500, 320000000, 0.0, 0.0, 0.0, GrowthDecision::kEnd}};
}

TEST(MeshGrowth, WhatWasWrittenIsReadBack) {
  const ScratchFolder folder;
  WriteMeshGrowth(folder / kMeshGrowthFile, ExampleGrowth());
  EXPECT_TRUE(ReadMeshGrowth(folder / kMeshGrowthFile) == ExampleGrowth());
  const nlohmann::json value = ReadJson(folder / kMeshGrowthFile);
  EXPECT_EQ(value["steps"][1]["reason"], "refined");
  EXPECT_TRUE(value["steps"][9]["psnr"].is_null());
  EXPECT_EQ(value["steps"][9]["empty_tets"], 2500);
  EXPECT_TRUE(value["steps"][2]["empty_tets"].is_null());
}

TEST(MeshGrowth, WhatIsWrongIsNamed) {
  const ScratchFolder folder;
  WriteMeshGrowth(folder / kMeshGrowthFile, ExampleGrowth());
  const nlohmann::json good = ReadJson(folder / kMeshGrowthFile);
  const auto refused = [&](const char* pointer, const nlohmann::json& value, const char* what) {
    nlohmann::json bad = good;
    bad[nlohmann::json::json_pointer(pointer)] = value;
    ExpectError<DataError>([&] { ParseMeshGrowth(bad, "growth.json"); }, {"growth.json", what});
  };
  refused("/schema", 2, "schema");
  refused("/steps", 7, "steps");
  refused("/steps/2/decision", "grow", "steps[2].decision");
  refused("/steps/0/vertices", -1, "steps[0].vertices");
  refused("/steps/0/seconds", "soon", "steps[0].seconds");
}

}  // namespace
}  // namespace tetrec
