#include "eval/surface_model.h"

#include "core/file.h"
#include "mesh/triangle_shapes.h"
#include "scratch_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tetrec {
namespace {

using ::testing::HasSubstr;

// A folder of the surface stage that contains surface.glb of so many bytes.
StageFacts StageWithGlb(const std::filesystem::path& folder, size_t bytes,
                        const char* coordinates) {
  WriteBytes(folder / "surface.glb", std::vector<uint8_t>(bytes, 'g'));
  return {"surface",
          folder,
          {{"outputs", {{{"path", "surface.glb"}, {"bytes", bytes}}}},
           {"notes", {{"coordinates", coordinates}}}}};
}

TEST(SurfaceModel, TheFileOfTheStageIsTakenWithItsFrame) {
  const ScratchFolder folder;
  const TriangleMesh mesh = TestSphere(8, 1);
  const Similarity3 input_from_surface{2, glm::dmat3(1.0), {10, 20, 30}};
  // The world's point (1, 2, 3) is (1, 3, -2) in a file with y up.
  const SurfaceModel world = MakeSurfaceModel(StageWithGlb(folder.path(), 5000, "world"), mesh,
                                              input_from_surface, folder / "scratch");
  EXPECT_EQ(world.glb, std::vector<uint8_t>(5000, 'g'));
  EXPECT_EQ(world.input_from_model * glm::dvec3(1, 3, -2), glm::dvec3(12, 24, 36));
  const SurfaceModel input = MakeSurfaceModel(StageWithGlb(folder.path(), 5000, "input"), mesh,
                                              input_from_surface, folder / "scratch");
  EXPECT_EQ(input.input_from_model * glm::dvec3(1, 2, 3), glm::dvec3(12, 24, 36));
}

TEST(SurfaceModel, ASurfaceTooLargeForThePageHasFewerTriangles) {
  const ScratchFolder folder;
  const TriangleMesh mesh = Plane(320, 1, 0);
  ASSERT_GT(mesh.triangles.size(), 200'000u);
  const SurfaceModel model = MakeSurfaceModel(StageWithGlb(folder.path(), 6'000'001, "world"), mesh,
                                              {}, folder / "scratch");
  EXPECT_LE(model.glb.size(), 6'000'000u);
  EXPECT_EQ(std::string(model.glb.begin(), model.glb.begin() + 4), "glTF");
  EXPECT_EQ(model.input_from_model * glm::dvec3(1, 2, 3), glm::dvec3(1, 2, 3));
  EXPECT_THAT(model.note, HasSubstr("triangles"));
}

TEST(SurfaceModel, WhereNothingCanBeShownTheReasonIsGiven) {
  const ScratchFolder folder;
  const StageFacts none{"surface", folder.path(), nlohmann::json::object()};
  const SurfaceModel empty = MakeSurfaceModel(none, {}, {}, folder / "scratch");
  EXPECT_TRUE(empty.glb.empty());
  EXPECT_THAT(empty.note, HasSubstr("no triangle"));
}

}  // namespace
}  // namespace tetrec
