#include "surface/export.h"

#include "core/error.h"
#include "core/ply.h"
#include "expect_error.h"
#include "foreign_readers.h"
#include "image/srgb.h"
#include "mesh/mesh_facts.h"
#include "scratch_folder.h"
#include "surface/glb.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

namespace tetrec {
namespace {

TriangleMesh Tetrahedron() {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1.5f, 0}, {0, 0, -0.1f}};
  mesh.colors_srgb = {{0, 0, 0}, {255, 0, 0}, {0, 128, 255}, {10, 20, 200}};
  mesh.triangles = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {0, 2, 3}};
  return mesh;
}

// Which of our vertices each of another program's is; programs may merge, split and sort vertices.
size_t VertexAt(const TriangleMesh& mesh, const glm::vec3& position) {
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    if (glm::distance(mesh.positions[v], position) < 1e-6f) return v;
  }
  ADD_FAILURE() << "no vertex at " << position.x << ", " << position.y << ", " << position.z;
  return 0;
}

TEST(SurfaceExport, AssimpReadsShapeAndWindingOfEveryFormat) {
  if (FindProgram("assimp").empty()) GTEST_SKIP() << "assimp-utils is not installed";
  const ScratchFolder folder;
  const TriangleMesh mesh = Tetrahedron();
  WriteTriangleMeshPly(folder / "surface.ply", mesh);
  WriteTriangleMeshObj(folder / "surface.obj", mesh);
  WriteTriangleMeshStl(folder / "surface.stl", mesh);
  WriteTriangleMeshGlb(folder / "surface.glb", mesh);
  const double volume = MeasureMesh(mesh).volume;
  ASSERT_GT(volume, 0);
  for (const char* name : {"surface.ply", "surface.obj", "surface.stl", "surface.glb"}) {
    SCOPED_TRACE(name);
    const TriangleMesh read = ReadByAssimp(folder / name);
    ASSERT_EQ(read.triangles.size(), mesh.triangles.size());
    double read_volume = 0;  // signed: negative if the winding is wrong
    for (const glm::uvec3& t : read.triangles) {
      const glm::dvec3 a(mesh.positions[VertexAt(mesh, read.positions[t.x])]),
          b(mesh.positions[VertexAt(mesh, read.positions[t.y])]),
          c(mesh.positions[VertexAt(mesh, read.positions[t.z])]);
      read_volume += glm::dot(a, glm::cross(b, c)) / 6;
    }
    EXPECT_NEAR(read_volume, volume, 1e-9);
  }
}

TEST(SurfaceExport, AssimpReadsTheColoursOfPlyObjAndGlb) {
  if (FindProgram("assimp").empty()) GTEST_SKIP() << "assimp-utils is not installed";
  const ScratchFolder folder;
  const TriangleMesh mesh = Tetrahedron();
  WriteTriangleMeshPly(folder / "surface.ply", mesh);
  WriteTriangleMeshObj(folder / "surface.obj", mesh);
  WriteTriangleMeshGlb(folder / "surface.glb", mesh);
  for (const char* name : {"surface.ply", "surface.obj", "surface.glb"}) {
    SCOPED_TRACE(name);
    const TriangleMesh read = ReadByAssimp(folder / name);
    ASSERT_EQ(read.colors_srgb.size(), read.positions.size());
    for (size_t v = 0; v < read.positions.size(); ++v) {
      const auto& color = mesh.colors_srgb[VertexAt(mesh, read.positions[v])];
      for (size_t c = 0; c < 3; ++c) {
        // glTF's vertex colours are linear, and assimp leaves them so.
        const bool linear = std::string(name) == "surface.glb";
        const double expected = linear ? 255 * LinearFromSrgb(color[c] / 255.0) : color[c];
        EXPECT_NEAR(read.colors_srgb[v][c], expected, 1) << "vertex " << v << ", channel " << c;
      }
    }
  }
}

// A square of two triangles whose texture is red on the left, green on the right, and dark below.
TriangleMesh TexturedSquare() {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  mesh.colors_srgb.assign(4, {9, 9, 9});
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  const glm::vec2 a(0.1f, 0.2f), b(0.9f, 0.2f), c(0.9f, 0.7f), d(0.1f, 0.7f);
  mesh.corner_coordinates = {{a, b, c}, {a, c, d}};
  return mesh;
}

TEST(SurfaceExport, AssimpReadsTextureCoordinatesOfObjAndGlb) {
  if (FindProgram("assimp").empty()) GTEST_SKIP() << "assimp-utils is not installed";
  const ScratchFolder folder;
  const TriangleMesh mesh = TexturedSquare();
  Image texture = MakeImage(64, 64, 3);
  WriteImage(folder / "surface.png", texture);
  WriteTextureMaterial(folder / "surface.mtl", "surface.png");
  WriteTriangleMeshObj(folder / "surface.obj", mesh, "surface.mtl");
  WriteTriangleMeshGlb(folder / "surface.glb", mesh, texture);
  for (const char* name : {"surface.obj", "surface.glb"}) {
    SCOPED_TRACE(name);
    EXPECT_TRUE(ReadByAssimp(folder / name).colors_srgb.empty());  // would darken the texture
    const PlyFile read = ReadPly((folder / name).string() + ".assimp.ply");
    const PlyElement* vertices = read.Find("vertex");
    ASSERT_NE(vertices, nullptr);
    const PlyProperty *s = vertices->Find("s"), *t = vertices->Find("t");
    ASSERT_TRUE(s != nullptr && t != nullptr);
    for (size_t v = 0; v < vertices->count; ++v) {
      const double x = vertices->Find("x")->values[v], y = vertices->Find("y")->values[v];
      EXPECT_NEAR(s->values[v], 0.1 + 0.8 * x, 1e-5);
      EXPECT_NEAR(t->values[v], 0.2 + 0.5 * y, 1e-5);
    }
  }
  // Its exit code is not 0 even where it succeeds.
  RunChild(FindProgram("assimp"), {"extract", (folder / "surface.glb").string(), "--texture=0"},
           {});
  EXPECT_EQ(ReadImage(folder / "surface_img0.jpg").width, 64);
}

TEST(ExportOptions, AKnownDistanceBecomesTheDistanceInTheFile) {
  ExportOptions options;
  options.known_distance = {0, 0, 1, 0, 3, 5, 0.2};  // 5 apart in the world
  options.Check();
  const Similarity3 input_from_world{7, glm::dmat3({0, 1, 0}, {-1, 0, 0}, {0, 0, 1}), {1, 2, 3}};
  const Similarity3 export_from_world = ExportFromWorld(options, input_from_world);
  EXPECT_NEAR(glm::distance(export_from_world * glm::dvec3(0, 0, 1),
                            export_from_world * glm::dvec3(0, 3, 5)),
              0.2, 1e-12);
}

TEST(ExportOptions, TheInputsCoordinatesAreThoseOfTheScene) {
  ExportOptions options;
  options.coordinates = ExportCoordinates::kInput;
  const Similarity3 input_from_world{7, glm::dmat3({0, 1, 0}, {-1, 0, 0}, {0, 0, 1}), {1, 2, 3}};
  const glm::dvec3 p(0.5, -0.25, 1);
  EXPECT_EQ(ExportFromWorld(options, input_from_world) * p, input_from_world * p);
  options.scale = 10;
  EXPECT_LT(
      glm::distance(ExportFromWorld(options, input_from_world) * p, 10.0 * (input_from_world * p)),
      1e-12);
}

TEST(ExportOptions, ThereIsAWayBackFromEveryFrameToTheInput) {
  const Similarity3 input_from_world{7, glm::dmat3({0, 1, 0}, {-1, 0, 0}, {0, 0, 1}), {1, 2, 3}};
  const glm::dvec3 p(0.5, -0.25, 1);
  for (const ExportCoordinates coordinates :
       {ExportCoordinates::kWorld, ExportCoordinates::kInput}) {
    for (const double scale : {1.0, 10.0}) {
      const ExportOptions options{.coordinates = coordinates, .scale = scale};
      const glm::dvec3 in_file = ExportFromWorld(options, input_from_world) * p;
      EXPECT_LT(
          glm::distance(InputFromExport(options, input_from_world) * in_file, input_from_world * p),
          1e-12);
    }
  }
}

TEST(ExportOptions, FilesWithYUpAreTurnedAndNotMirrored) {
  const Similarity3 turn = YUpFromExport({});
  EXPECT_EQ(turn * glm::dvec3(1, 2, 3), glm::dvec3(1, 3, -2));
  EXPECT_DOUBLE_EQ(glm::determinant(turn.rotation), 1.0);
  EXPECT_EQ(YUpFromExport({.coordinates = ExportCoordinates::kInput}) * glm::dvec3(1, 2, 3),
            glm::dvec3(1, 2, 3));
}

TEST(ExportFrame, CoordinatesThatAreTooLargeForFloatsAreRefused) {
  // A subject of two metres where a map has its zone's coordinates.
  const Similarity3 input_from_world{1.0, glm::dmat3(1.0), {4e5, 5.4e6, 300}};
  const Bounds3 subject{glm::dvec3(-1), glm::dvec3(1)};
  ExpectError<DataError>(
      [&] {
        CheckFloatsSuffice({.coordinates = ExportCoordinates::kInput}, input_from_world, subject);
      },
      {"3.464 in diagonal, is too far from 0", "400000,5.4e+06,300", "leave out --coordinates"});
  CheckFloatsSuffice({}, input_from_world, subject);
  CheckFloatsSuffice({.coordinates = ExportCoordinates::kInput},
                     {1.0, glm::dmat3(1.0), {400, 540, 300}}, subject);
}

TEST(ExportCrop, ABoxWithoutAWholeTetIsRefusedForFields) {
  TetMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.tets = {{0, 1, 2, 3}};
  const Similarity3 input_from_world{2, glm::dmat3(1.0), {10, 0, 0}};
  const auto check = [&](std::vector<ExportFormat> formats, std::vector<double> crop) {
    CheckCropHasTets({.formats = std::move(formats),
                      .coordinates = ExportCoordinates::kInput,
                      .crop = std::move(crop)},
                     input_from_world, mesh);
  };
  const std::vector<double> whole = {10, 0, 0, 12, 2, 2}, part = {10, 0, 0, 11.9, 2, 2};
  for (const ExportFormat format :
       {ExportFormat::kVtu, ExportFormat::kMedit, ExportFormat::kGmsh}) {
    check({format}, whole);
    check({format}, {});
    ExpectError<DataError>([&] { check({format}, part); },
                           {"no whole tet", "10,0,0,11.9,2,2", "larger box"});
  }
  check({ExportFormat::kPly}, part);  // of a surface, parts of triangles are enough
}

TEST(ExportOptions, RefusesWhatMakesNoSense) {
  const auto refused = [](const ExportOptions& options, const char* name) {
    ExpectError<UsageError>([&] { options.Check(); }, {name});
  };
  refused({.scale = 0}, "scale");
  refused({.scale = NAN}, "scale");
  refused({.known_distance = {1, 2, 3, 1, 2, 3, 1}}, "known_distance");
  refused({.known_distance = {1, 2, 3, 1, 2, 4, 0}}, "known_distance");
  refused({.crop = {0, 0, 0, 1, 0, 1}}, "crop");
  ExportOptions{.crop = {0, 0, 0, 1, 1, 1}}.Check();
}

}  // namespace
}  // namespace tetrec
