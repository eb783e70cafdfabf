#include "mesh/tet_mesh.h"

#include "core/error.h"
#include "mesh/delaunay.h"
#include "mesh/tet_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <set>

namespace tetrec {
namespace {

using ::testing::HasSubstr;
using ::testing::Property;
using ::testing::Throws;

TetMesh RandomMesh(int points, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(-1, 1);
  std::vector<glm::vec3> positions;
  for (int i = 0; i < points; ++i) {
    const float x = unit(random), y = unit(random), z = unit(random);
    positions.emplace_back(x, y, z);
  }
  return BuildDelaunay(positions).mesh;
}

// Two tets, one on each side of the triangle 1, 2, 3.
TetMesh TwoTets() {
  TetMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
  mesh.tets = {{0, 1, 2, 3}, {4, 1, 3, 2}};
  mesh.neighbors = ComputeNeighbors(mesh.tets, 5);
  return mesh;
}

// Tets as sorted corner positions: the same for every order of vertices and tets.
std::multiset<std::vector<std::array<float, 3>>> AsGeometry(const TetMesh& mesh) {
  std::multiset<std::vector<std::array<float, 3>>> tets;
  for (const glm::uvec4& tet : mesh.tets) {
    std::vector<std::array<float, 3>> corners;
    for (int i = 0; i < 4; ++i) {
      const glm::vec3& p = mesh.positions[tet[i]];
      corners.push_back({p.x, p.y, p.z});
    }
    std::sort(corners.begin(), corners.end());
    tets.insert(corners);
  }
  return tets;
}

template <class F>
void ExpectRefused(F&& call, const std::string& reason) {
  EXPECT_THAT(call, Throws<DataError>(Property(&DataError::what, HasSubstr(reason))));
}

int SharedVertices(const glm::uvec4& a, const glm::uvec4& b) {
  int shared = 0;
  for (int i = 0; i < 4; ++i) shared += glm::any(glm::equal(b, glm::uvec4(a[i])));
  return shared;
}

// All faces at once, and a quarter of them at a time.
TEST(ComputeNeighbors, LinksTheTetsThatShareThreeVertices) {
  const TetMesh mesh = RandomMesh(200, 1);
  for (const uint32_t faces_at_once : {1u << 21, 1u}) {
    const auto neighbors = ComputeNeighbors(mesh.tets, mesh.positions.size(), faces_at_once);
    for (uint32_t a = 0; a < mesh.tets.size(); ++a) {
      for (uint32_t b = 0; b < mesh.tets.size(); ++b) {
        const bool is_linked = glm::any(glm::equal(neighbors[a], glm::uvec4(b)));
        ASSERT_EQ(is_linked, SharedVertices(mesh.tets[a], mesh.tets[b]) == 3) << a << ", " << b;
      }
    }
  }
}

TEST(ComputeNeighbors, LinksFacesOppositeTheSameVertices) {
  const TetMesh mesh = TwoTets();
  EXPECT_EQ(mesh.neighbors[0], glm::uvec4(1, kNoTet, kNoTet, kNoTet));
  EXPECT_EQ(mesh.neighbors[1], glm::uvec4(0, kNoTet, kNoTet, kNoTet));
}

TEST(ComputeNeighbors, RefusesWhatIsNoMesh) {
  const std::vector<glm::uvec4> three = {{0, 1, 2, 3}, {4, 1, 2, 3}, {5, 1, 2, 3}};
  ExpectRefused([&] { ComputeNeighbors(three, 6); }, "shared by tets");
  ExpectRefused([&] { ComputeNeighbors(three, 5); }, "names vertex 5 of 5");
  const std::vector<glm::uvec4> twice = {{0, 1, 1, 3}};
  ExpectRefused([&] { ComputeNeighbors(twice, 4); }, "twice");
}

TEST(FaceVertices, AreWoundOutward) {
  const TetMesh mesh = RandomMesh(50, 2);
  for (const glm::uvec4& tet : mesh.tets) {
    for (int i = 0; i < 4; ++i) {
      const glm::dvec3 a(mesh.positions[tet[kFaceVertices[i][0]]]);
      const glm::dvec3 b(mesh.positions[tet[kFaceVertices[i][1]]]);
      const glm::dvec3 c(mesh.positions[tet[kFaceVertices[i][2]]]);
      const glm::dvec3 opposite(mesh.positions[tet[i]]);
      EXPECT_LT(glm::dot(glm::cross(b - a, c - a), opposite - a), 0);
    }
  }
}

TEST(CheckTetMesh, AcceptsAValidMesh) {
  EXPECT_NO_THROW(CheckTetMesh(TwoTets()));
  EXPECT_NO_THROW(CheckTetMesh(RandomMesh(500, 3)));
}

TEST(CheckTetMesh, NamesTheFirstOffence) {
  const auto refused = [](const std::string& reason, auto&& damage) {
    TetMesh mesh = TwoTets();
    damage(mesh);
    ExpectRefused([&] { CheckTetMesh(mesh); }, reason);
  };
  refused("no tet", [](TetMesh& m) { m = {}; });
  refused("vertex 2 is not finite",
          [](TetMesh& m) { m.positions[2].z = std::numeric_limits<float>::infinity(); });
  refused("names vertex 5 of 5", [](TetMesh& m) { m.tets[1][0] = 5; });
  refused("names neighbour 2 of 2", [](TetMesh& m) { m.neighbors[1][0] = 2; });
  refused("inverted", [](TetMesh& m) { std::swap(m.tets[1][0], m.tets[1][1]); });
  refused("flat", [](TetMesh& m) { m.positions[0] = {0.25f, 0.25f, 0.5f}; });
  refused("tet 0 links to itself over face 1", [](TetMesh& m) { m.neighbors[0][1] = 0; });
  refused("is shared with", [](TetMesh& m) {
    for (glm::uvec4& neighbors : m.neighbors) neighbors = glm::uvec4(kNoTet);
  });
  refused("no link back", [](TetMesh& m) {
    for (int i = 0; i < 4; ++i) {
      if (m.neighbors[0][i] == 1) m.neighbors[0][i] = kNoTet;
    }
  });
  refused("which that lacks", [](TetMesh& m) {
    for (int i = 0; i < 4; ++i) m.neighbors[0][i] = 1;
  });
  refused("belongs to no tet", [](TetMesh& m) { m.positions.push_back({3, 3, 3}); });
  refused("neighbours for", [](TetMesh& m) { m.neighbors.pop_back(); });
}

TEST(CheckConvexDomain, NamesTheFirstOffence) {
  const auto refused = [](const std::string& reason, auto&& damage) {
    TetMesh mesh = TwoTets();
    damage(mesh);
    EXPECT_NO_THROW(CheckTetMesh(mesh));
    ExpectRefused([&] { CheckConvexDomain(mesh); }, reason);
  };
  EXPECT_NO_THROW(CheckConvexDomain(TwoTets()));
  refused("not convex", [](TetMesh& m) {
    const TetMesh other = TwoTets();
    for (const glm::vec3& p : other.positions) m.positions.push_back(p + glm::vec3(9));
    for (const glm::uvec4& t : other.tets) m.tets.push_back(t + glm::uvec4(5));
    m.neighbors = ComputeNeighbors(m.tets, m.positions.size());
  });
  refused("not convex", [](TetMesh& m) { m.positions[4] = {2, 2, -0.5f}; });
}

TEST(CheckConvexDomain, RefusesAMeshWithACavity) {
  TetMesh mesh = RandomMesh(400, 4);
  // A tet whose corners and neighbours are all inside.
  const auto hollow = std::find_if(mesh.tets.begin(), mesh.tets.end(), [&](const glm::uvec4& tet) {
    const size_t t = size_t(&tet - mesh.tets.data());
    for (int i = 0; i < 4; ++i) {
      if (mesh.neighbors[t][i] == kNoTet) return false;
      if (glm::length(mesh.positions[tet[i]]) > 0.5f) return false;
    }
    return true;
  });
  ASSERT_NE(hollow, mesh.tets.end());
  mesh.tets.erase(hollow);
  mesh.neighbors = ComputeNeighbors(mesh.tets, mesh.positions.size());
  EXPECT_NO_THROW(CheckTetMesh(mesh));
  ExpectRefused([&] { CheckConvexDomain(mesh); }, "not convex");
}

TEST(MeasureQuality, GivesOneForTheRegularTet) {
  TetMesh mesh;
  mesh.positions = {{1, 1, 1}, {1, -1, -1}, {-1, -1, 1}, {-1, 1, -1}};
  mesh.tets = {{0, 1, 2, 3}};
  mesh.neighbors = {glm::uvec4(kNoTet)};
  CheckTetMesh(mesh);
  const TetMeshQuality quality = MeasureQuality(mesh);
  EXPECT_NEAR(quality.min_radius_ratio, 1, 1e-14);  // double rounding
  EXPECT_NEAR(quality.total_volume, 8.0 / 3, 1e-14);
  EXPECT_EQ(quality.boundary_faces, 4u);
}

TEST(MeasureQuality, FallsToZeroForASliver) {
  TetMesh mesh;
  mesh.tets = {{0, 1, 2, 3}};
  mesh.neighbors = {glm::uvec4(kNoTet)};
  double before = 1;
  for (const float height : {0.5f, 0.1f, 0.01f, 0.001f}) {
    mesh.positions = {{1, 0, -height}, {-1, 0, -height}, {0, -1, height}, {0, 1, height}};
    const double ratio = MeasureQuality(mesh).min_radius_ratio;
    EXPECT_LT(ratio, before);
    before = ratio;
  }
  EXPECT_LT(before, 1e-2);
}

TEST(SortAlongMortonCurve, KeepsTheMesh) {
  TetMesh mesh = RandomMesh(1000, 5);
  // The triangulation is sorted already, so it is shuffled first.
  std::vector<uint32_t> order(mesh.positions.size());
  for (size_t i = 0; i < order.size(); ++i) order[i] = uint32_t(i);
  std::shuffle(order.begin(), order.end(), std::mt19937(6));
  TetMesh shuffled = mesh;
  for (size_t i = 0; i < order.size(); ++i) shuffled.positions[order[i]] = mesh.positions[i];
  for (glm::uvec4& tet : shuffled.tets) {
    for (int i = 0; i < 4; ++i) tet[i] = order[tet[i]];
  }
  std::shuffle(shuffled.tets.begin(), shuffled.tets.end(), std::mt19937(7));
  shuffled.neighbors = ComputeNeighbors(shuffled.tets, shuffled.positions.size());
  const TetMesh before = shuffled;
  const std::vector<uint32_t> old_of_new = SortAlongMortonCurve(shuffled).vertices;
  CheckTetMesh(shuffled);
  EXPECT_EQ(AsGeometry(shuffled), AsGeometry(mesh));
  for (size_t v = 0; v < old_of_new.size(); ++v) {
    EXPECT_EQ(shuffled.positions[v], before.positions[old_of_new[v]]);
  }
  EXPECT_EQ(shuffled.positions, mesh.positions) << "the order depends on positions only";
}

TEST(SortAlongMortonCurve, BringsNeighborsClose) {
  TetMesh mesh = RandomMesh(5000, 8);
  double distance = 0, count = 0;
  for (size_t t = 0; t < mesh.tets.size(); ++t) {
    for (int i = 0; i < 4; ++i) {
      if (mesh.neighbors[t][i] == kNoTet) continue;
      distance += std::abs(double(mesh.neighbors[t][i]) - double(t));
      ++count;
    }
  }
  // In random order two tets are a third of their number apart on average.
  EXPECT_LT(distance / count, 0.1 * double(mesh.tets.size()));
}

std::vector<uint8_t> AsBytes(const TetMesh& mesh) {
  ByteWriter writer;
  AppendTetMeshHead(writer, mesh);
  for (const auto& array : TetMeshArrays(mesh)) writer.WriteArray(array);
  return writer.bytes();
}

TEST(ParseTetMesh, ReadsWhatWasWritten) {
  const TetMesh mesh = RandomMesh(200, 9);
  const TetMesh read = ParseTetMesh(AsBytes(mesh), "mesh.tet");
  EXPECT_EQ(read.positions, mesh.positions);
  EXPECT_EQ(read.tets, mesh.tets);
  EXPECT_EQ(read.neighbors, mesh.neighbors);
}

TEST(ParseTetMesh, RefusesEveryPrefixAndTrailingBytes) {
  std::vector<uint8_t> bytes = AsBytes(TwoTets());
  for (size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_THROW(ParseTetMesh(std::span(bytes).first(size), "mesh.tet"), DataError) << size;
  }
  bytes.push_back(0);
  EXPECT_THROW(ParseTetMesh(bytes, "mesh.tet"), DataError);
}

TEST(ParseTetMesh, RefusesCountsBeyondTheFileBeforeTakingMemory) {
  const std::vector<uint8_t> good = AsBytes(TwoTets());
  for (const size_t at : {size_t{8}, size_t{16}}) {
    for (const uint64_t count : {uint64_t{6}, uint64_t{1} << 31, uint64_t{1} << 32,
                                 uint64_t{1} << 62, uint64_t{1} << 63, ~uint64_t{0}}) {
      std::vector<uint8_t> bytes = good;
      std::memcpy(bytes.data() + at, &count, sizeof(count));
      EXPECT_THROW(ParseTetMesh(bytes, "mesh.tet"), DataError) << at << " " << count;
    }
  }
}

TEST(ParseTetMesh, RefusesOrSurvivesEveryFlippedByte) {
  const std::vector<uint8_t> good = AsBytes(RandomMesh(12, 10));
  for (size_t i = 0; i < good.size(); ++i) {
    for (const uint8_t mask : {uint8_t{0x01}, uint8_t{0x80}, uint8_t{0xFF}}) {
      std::vector<uint8_t> bytes = good;
      bytes[i] ^= mask;
      try {
        CheckTetMesh(ParseTetMesh(bytes, "mesh.tet"));
      } catch (const DataError&) {
      }
    }
  }
}

TEST(ParseTetMesh, TellsAnotherVersionFromAnotherFile) {
  std::vector<uint8_t> bytes = AsBytes(TwoTets());
  bytes[7] = '9';
  ExpectRefused([&] { ParseTetMesh(bytes, "mesh.tet"); }, "format version '9'");
  bytes[0] = 'X';
  ExpectRefused([&] { ParseTetMesh(bytes, "mesh.tet"); }, "is not a tet mesh");
}

TEST(ParseTetMesh, NamesTheFileOfAMeshThatIsNoGood) {
  TetMesh mesh = TwoTets();
  mesh.positions.push_back({3, 3, 3});
  ExpectRefused([&] { ParseTetMesh(AsBytes(mesh), "mesh.tet"); },
                "mesh.tet: vertex 5 belongs to no tet");
}

}  // namespace
}  // namespace tetrec
