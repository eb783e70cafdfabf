#include "start/tetgen.h"

#include "core/child_process.h"
#include "core/error.h"
#include "core/file.h"
#include "mesh/delaunay.h"
#include "scratch_folder.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <limits>
#include <random>

namespace tetrec {
namespace {

constexpr const char* kNodes = "4 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n# a comment\n";
constexpr const char* kElements = "1 4 0\n0 1 0 2 3\n";

std::filesystem::path Folder(const std::string& name) {
  static const ScratchFolder scratch;
  const std::filesystem::path folder = scratch / name;
  std::filesystem::create_directories(folder);
  return folder;
}

TEST(ParseTetgen, TurnsTetsToPositiveOrientation) {
  const TetMesh mesh = ParseTetgen(kNodes, kElements, "a.node", "a.ele");
  EXPECT_EQ(mesh.tets.size(), 1u);
  EXPECT_NO_THROW(CheckTetMesh(mesh));
}

TEST(ParseTetgen, RefusesWhatItCannotTrust) {
  const auto refused = [](const std::string& nodes, const std::string& elements) {
    EXPECT_THROW(ParseTetgen(nodes, elements, "a.node", "a.ele"), DataError) << nodes << elements;
  };
  refused("", kElements);
  refused(kNodes, "");
  refused("4611686018427387904 3 0 0\n0 0 0 0\n", kElements);
  refused("1e400 3 0 0\n", kElements);
  refused("-1 3 0 0\n", kElements);
  refused("4 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n", kElements);
  refused("4 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 nan\n", kElements);
  refused("4 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n7 0 0 1\n", kElements);
  refused(kNodes, "1 4 0\n0 1 0 2 4\n");
  refused(kNodes, "1 4 0\n0 1 0 2\n");
  refused(kNodes, "1 4 0\n0 1 0 2 x\n");
  refused(kNodes, "1 4 0\n0 1 0 2 2\n");
  refused(kNodes, "99999999 4 0\n0 1 0 2 3\n");
}

TEST(TetrahedralizeBox, RefusesBadInputBeforeTetgenSeesIt) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::filesystem::path folder = Folder("tetgen_bad");
  const Bounds3 box{glm::dvec3(-1), glm::dvec3(1)};
  EXPECT_THROW(TetrahedralizeBox(box, 0, 1, folder), DataError);
  EXPECT_THROW(TetrahedralizeBox(box, nan, 1, folder), DataError);
  EXPECT_THROW(TetrahedralizeBox({{-1, -1, 0}, {1, 1, 0}}, 1, 1, folder), DataError);
  EXPECT_THROW(TetrahedralizeBox({{nan, -1, 0}, {1, 1, 1}}, 1, 1, folder), DataError);
  EXPECT_THROW(TetrahedralizeBox({}, 1, 1, folder), DataError);
}

TEST(TetrahedralizeBox, KeepsTheBoxOf12Triangles) {
  if (FindProgram("tetgen").empty()) GTEST_SKIP() << "tetgen is not installed";
  const TetMesh mesh =
      TetrahedralizeBox({{-1, -1, -0.5}, {1, 1, 0.5}}, 0.002, 1, Folder("tetgen_box"));
  const TetMeshQuality quality = MeasureQuality(mesh);
  EXPECT_EQ(quality.boundary_faces, 12u);
  EXPECT_NEAR(quality.total_volume, 4, 1e-6);  // vertices are rounded to floats
  EXPECT_GT(mesh.tets.size(), 1000u);
}

// TetGen is an independent program: the Delaunay tets of points in general position are unique.
TEST(BuildDelaunay, MakesAsManyTetsAsTetgen) {
  const std::filesystem::path program = FindProgram("tetgen");
  if (program.empty()) GTEST_SKIP() << "tetgen is not installed";
  for (unsigned seed = 1; seed <= 5; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> unit(-1, 1);
    std::vector<glm::vec3> points;
    std::string text = "1000 3 0 0\n";
    for (int i = 0; i < 1000; ++i) {
      const float x = unit(random), y = unit(random), z = unit(random);
      points.emplace_back(x, y, z);
      text += fmt::format("{} {:.9g} {:.9g} {:.9g}\n", i, x, y, z);
    }
    const std::filesystem::path folder = Folder("tetgen_oracle");
    WriteText(folder / "p.node", text);
    ChildOptions options;
    options.working_folder = folder;
    options.log = folder / "log";
    ASSERT_EQ(RunChild(program, {"-Q", "p.node"}, options).exit_code, 0);
    const TetMesh theirs = ParseTetgen(ReadText(folder / "p.1.node"), ReadText(folder / "p.1.ele"),
                                       "p.1.node", "p.1.ele");
    const TetMesh ours = BuildDelaunay(points).mesh;
    EXPECT_EQ(ours.tets.size(), theirs.tets.size()) << "seed " << seed;
    EXPECT_NEAR(MeasureQuality(ours).total_volume, MeasureQuality(theirs).total_volume, 1e-12);
  }
}

}  // namespace
}  // namespace tetrec
