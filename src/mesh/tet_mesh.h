// Tetrahedral meshes as flat arrays.
#pragma once

#include <glm/glm.hpp>

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace tetrec {

constexpr uint32_t kNoTet = 0xFFFFFFFFu;

// V vertices, T tets. Each tet is positively oriented: det(p1 - p0, p2 - p0, p3 - p0) > 0. Face i
// and neighbour i lie opposite vertex i; kNoTet marks the boundary.
struct TetMesh {
  std::vector<glm::vec3> positions;   // (V) [world units]
  std::vector<glm::uvec4> tets;       // (T) vertex ids
  std::vector<glm::uvec4> neighbors;  // (T) tet ids
};

// Vertices of face i (opposite vertex i) of a positively oriented tet, wound so that the normal
// (b - a) x (c - a) points out of the tet.
constexpr int kFaceVertices[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

// Vertices of a tet's edges.
constexpr int kTetEdges[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};

struct TetMeshQuality {
  double min_radius_ratio = 0, mean_radius_ratio = 0;  // 3 r_in / r_circ: 1 regular, 0 flat
  double min_volume = 0, mean_volume = 0, total_volume = 0;
  uint64_t boundary_faces = 0;
};

// Signed volume, positive for a positively oriented tet.
double TetVolume(const TetMesh& mesh, const glm::uvec4& tet);
// 3 r_in / r_circ: 1 for a regular tet, 0 for a flat one.
double RadiusRatio(const TetMesh& mesh, const glm::uvec4& tet);

// Finds neighbours by vertex ids. Throws DataError if more than two tets share a face. Takes 12
// bytes for each of `faces_at_once` faces, or of a quarter of all if that is more, beside the
// result.
std::vector<glm::uvec4> ComputeNeighbors(std::span<const glm::uvec4> tets, size_t vertex_count,
                                         uint32_t faces_at_once = uint32_t{1} << 21);

// What a check expects of tets. Only moves by the method of the DiffTetVR article
// (optimize/article_motion.h) turn tets inside out, and only what reads a fitted field accepts
// them.
enum class Orientations { kPositive, kAny };

// Throws DataError that names the first fault: a position that is not finite, an id out of range, a
// tet that is not positively oriented (exact predicate), an unreferenced vertex, a link that is not
// symmetric or not over equal faces. Takes linear time, a second for 4 M tets. A face that two tets
// share without a link is not a fault here but part of the boundary.
void CheckTets(const TetMesh& mesh, Orientations expected = Orientations::kPositive);

// Runs CheckTets and checks that no link is missing. Holes, cavities and several parts are allowed.
void CheckTetMesh(const TetMesh& mesh, Orientations expected = Orientations::kPositive);

// The number of tets that are flat or inside out (exact predicate).
uint64_t CountDegenerateTets(const TetMesh& mesh);

// For stages that require a convex domain. Throws DataError unless the mesh is connected and its
// boundary is convex.
void CheckConvexDomain(const TetMesh& mesh);

TetMeshQuality MeasureQuality(const TetMesh& mesh);

// The old ids of a reordered mesh's vertices (V) and tets (T).
struct MeshOrder {
  std::vector<uint32_t> vertices, tets;
};

// Sorts vertices and tets along a Morton curve (marching is 1.9 times faster than in random order
// at 1 M tets). A mesh may lack its links.
MeshOrder SortAlongMortonCurve(TetMesh& mesh);

// The .tet format, little endian: "TETRECM1", u64 V, u64 T, positions f32 x 3 V, tets u32 x 4 T,
// neighbours u32 x 4 T. The reader checks counts and runs CheckTetMesh.
void WriteTetMesh(const std::filesystem::path& path, const TetMesh& mesh);
TetMesh ReadTetMesh(const std::filesystem::path& path);
TetMesh ParseTetMesh(std::span<const uint8_t> bytes, const std::string& name);

}  // namespace tetrec
