#include "core/error.h"
#include "core/file.h"
#include "expect_error.h"
#include "mesh/triangle_mesh.h"
#include "scratch_folder.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>

namespace tetrec {
namespace {

std::filesystem::path Path(const std::string& name) {
  static const ScratchFolder folder;
  return folder / name;
}

TriangleMesh Tetrahedron() {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1.5f, 0}, {0, 0, -0.1f}};
  mesh.colors_srgb = {{0, 0, 0}, {255, 0, 0}, {0, 128, 0}, {1, 2, 3}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  return mesh;
}

TEST(TriangleMeshFile, PlyReadsBackAsItWasWritten) {
  const TriangleMesh mesh = Tetrahedron();
  WriteTriangleMeshPly(Path("tetrahedron.ply"), mesh);
  const TriangleMesh read = ReadTriangleMesh(Path("tetrahedron.ply"));
  EXPECT_EQ(read.positions, mesh.positions);
  EXPECT_EQ(read.colors_srgb, mesh.colors_srgb);
  EXPECT_EQ(read.triangles, mesh.triangles);
}

TEST(TriangleMeshFile, MeshesTooFarFromZeroForFloatsAreRefused) {
  const auto text = [](const char* x) {
    return fmt::format(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\n"
        "property double z\nelement face 1\nproperty list uchar uint vertex_index\nend_header\n"
        "{0} 0 0\n{0} 1 0\n{0} 0 2\n3 0 1 2\n",
        x);
  };
  WriteText(Path("far.ply"), text("5400000"));
  ExpectError<DataError>([] { ReadTriangleMesh(Path("far.ply")); },
                         {"far.ply", "2.236 in diagonal is too far from 0", "5.4e+06"});
  WriteText(Path("near.ply"), text("540"));
  EXPECT_EQ(ReadTriangleMesh(Path("near.ply")).positions.size(), 3u);
}

TEST(TriangleMeshFile, PlyFacesBecomeFansAndFloatColoursBytes) {
  WriteText(Path("quad.ply"),
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\n"
            "property double z\nproperty float red\nproperty float green\nproperty float blue\n"
            "element face 1\nproperty list uchar uint vertex_index\nend_header\n"
            "0 0 0 0 0.5 1\n1 0 0 0 0 0\n1 1 0 2 -1 0\n0 1 0 0 0 0\n4 0 1 2 3\n");
  const TriangleMesh mesh = ReadTriangleMesh(Path("quad.ply"));
  EXPECT_EQ(mesh.triangles, (std::vector<glm::uvec3>{{0, 1, 2}, {0, 2, 3}}));
  EXPECT_EQ(mesh.colors_srgb[0], (std::array<uint8_t, 3>{0, 128, 255}));
  EXPECT_EQ(mesh.colors_srgb[2], (std::array<uint8_t, 3>{255, 0, 0}));
}

TEST(TriangleMeshFile, PlyCarriesTextureCoordinatesOfFaces) {
  TriangleMesh mesh = Tetrahedron();
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    mesh.corner_coordinates.push_back({glm::vec2(0.25f * float(t), 0), {0.5f, 1}, {0, 0.125f}});
  }
  WriteTriangleMeshPly(Path("textured.ply"), mesh, "a.png");
  EXPECT_EQ(ReadTriangleMesh(Path("textured.ply")).corner_coordinates, mesh.corner_coordinates);
  EXPECT_NE(ReadText(Path("textured.ply")).find("comment TextureFile a.png\n"), std::string::npos);
}

TEST(TriangleMeshFile, PlyFacesWithoutUsableTextureCoordinatesHaveNone) {
  const auto coordinates_of = [](const std::string& lists) {
    WriteText(Path("uv.ply"),
              "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
              "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
              "property list uchar float texcoord\nend_header\n"
              "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3 " +
                  lists + "\n");
    return ReadTriangleMesh(Path("uv.ply")).corner_coordinates;
  };
  const std::array<glm::vec2, 3> first{glm::vec2(0, 0), {1, 0}, {1, 1}},
      second{glm::vec2(0, 0), {1, 1}, {0, 1}};
  EXPECT_EQ(coordinates_of("8 0 0 1 0 1 1 0 1"), (std::vector{first, second}));
  EXPECT_TRUE(coordinates_of("0").empty());
  EXPECT_TRUE(coordinates_of("6 0 0 1 0 1 1").empty());
  EXPECT_TRUE(coordinates_of("8 0 0 1 0 1 nan 0 1").empty());
}

TEST(TriangleMeshFile, AnObjWithATextureNamesItsMaterialAndHasNoVertexColours) {
  TriangleMesh mesh = Tetrahedron();
  mesh.corner_coordinates.assign(4, {glm::vec2(0, 0), {0.5f, 0}, {0, 0.25f}});
  WriteTriangleMeshObj(Path("textured.obj"), mesh, "textured.mtl");
  WriteTextureMaterial(Path("textured.mtl"), "textured.png");
  const std::string text = ReadText(Path("textured.obj"));
  EXPECT_NE(text.find("mtllib textured.mtl\n"), std::string::npos) << text;
  EXPECT_NE(text.find("v 1 0 0\n"), std::string::npos) << text;
  EXPECT_NE(text.find("vt 0 0.25\n"), std::string::npos) << text;
  EXPECT_NE(text.find("f 1/1 3/2 2/3\n"), std::string::npos) << text;
  EXPECT_NE(ReadText(Path("textured.mtl")).find("map_Kd textured.png\n"), std::string::npos);
}

TEST(TriangleMeshFile, RefusesPlyThatIsNoMesh) {
  const auto refused = [](const std::string& body) {
    WriteText(Path("bad.ply"), "ply\nformat ascii 1.0\n" + body);
    EXPECT_THROW(ReadTriangleMesh(Path("bad.ply")), DataError) << body;
  };
  const std::string vertices =
      "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string faces = "element face 1\nproperty list uchar int vertex_indices\n";
  refused(vertices + "end_header\n0 0 0\n1 0 0\n0 1 0\n");
  refused(vertices + faces + "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n");
  refused(vertices + faces + "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n");
  refused(vertices + faces + "end_header\n0 0 0\n1 0 0\n0 1 0\n2 0 1\n");
  refused(vertices + faces + "end_header\n0 0 0\n1 0 0\n0 nan 0\n3 0 1 2\n");
  refused("element vertex 0\nproperty float x\n" + faces + "end_header\n0\n");
}

TEST(TriangleMeshFile, ObjCountsFromOneAndCarriesColours) {
  WriteTriangleMeshObj(Path("tetrahedron.obj"), Tetrahedron());
  const std::string text = ReadText(Path("tetrahedron.obj"));
  EXPECT_NE(text.find("v 1 0 0 1 0 0\n"), std::string::npos) << text;
  EXPECT_NE(text.find("f 1 3 2\n"), std::string::npos) << text;
}

}  // namespace
}  // namespace tetrec
