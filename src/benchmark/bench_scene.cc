// Scenes for benchmarks: fields of a given size and cameras around or inside them.
#include "benchmark/bench_scene.h"

#include "field/change_storage.h"
#include "geometry/look_at.h"
#include "mesh/boundary.h"
#include "mesh/delaunay.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

namespace tetrec {
namespace {

// Mean of Delaunay meshes of random points.
constexpr double kTetsPerPoint = 6.63;

// Points and the values of the field there.
struct Samples {
  std::vector<glm::vec3> positions, color_srgb;
  std::vector<float> density;

  void Add(const glm::vec3& position, const glm::vec3& color, float sigma) {
    positions.push_back(position);
    color_srgb.push_back(color);
    density.push_back(sigma);
  }
};

RadianceField MeshOf(const Samples& samples) {
  DelaunayResult delaunay = BuildDelaunay(samples.positions);
  RadianceField field{std::move(delaunay.mesh), {}, {}};
  for (uint32_t point : delaunay.point_of_vertex) {
    field.density.push_back(samples.density[point]);
    field.color_srgb.push_back(samples.color_srgb[point]);
  }
  return field;
}

}  // namespace

int GridOfTets(double tets) {
  return std::max(1, int(std::lround(std::cbrt(tets / kTetsPerPoint))));
}

std::vector<glm::vec3> JitteredCube(int grid) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> jitter(0.1, 0.9);
  std::vector<glm::vec3> points;
  for (int i = 0; i < 8; ++i) points.emplace_back(i & 1, i >> 1 & 1, i >> 2);
  for (int i = 0; i < grid * grid * grid; ++i) {
    const glm::dvec3 cell(i % grid, i / grid % grid, i / grid / grid);
    const glm::dvec3 offset(jitter(random), jitter(random), jitter(random));
    points.emplace_back((cell + offset) / double(grid));
  }
  return points;
}

RadianceField BallOn(TetMesh mesh) {
  RadianceField field;
  field.mesh = std::move(mesh);
  for (const glm::vec3& p : field.mesh.positions) {
    const float radius = glm::length(p - glm::vec3(0.5f));
    field.density.push_back(25.0f * std::clamp((0.4f - radius) / 0.1f, 0.0f, 1.0f));
    field.color_srgb.push_back(0.5f + 0.5f * glm::sin(20.0f * p));
  }
  return field;
}

RadianceField BallField(int grid) { return BallOn(BuildDelaunay(JitteredCube(grid)).mesh); }

RadianceField BallFieldOfTets(uint64_t tets) { return BallField(GridOfTets(double(tets))); }

RadianceField Resample(const RadianceField& of_any_storage, uint64_t tets, uint64_t seed) {
  const RadianceField field = WithStorage(of_any_storage, FieldStorage::kVertex);
  const TetMesh& mesh = field.mesh;
  // Assumes as many tets per point as the field's own mesh has.
  const size_t vertices = mesh.positions.size();
  const size_t wanted = size_t(double(tets) * double(vertices) / double(mesh.tets.size()));
  std::mt19937_64 random(seed);
  Samples samples;
  const auto keep = [&](size_t v) {
    samples.Add(mesh.positions[v], field.color_srgb[v], field.density[v]);
  };
  const std::vector<uint8_t> on_hull = BoundaryVertices(mesh);
  std::vector<uint32_t> inner;
  for (uint32_t v = 0; v < vertices; ++v) {
    if (on_hull[v]) {
      keep(v);
    } else {
      inner.push_back(v);
    }
  }
  std::shuffle(inner.begin(), inner.end(), random);
  for (size_t i = 0; i < inner.size() && samples.density.size() < wanted; ++i) keep(inner[i]);
  while (samples.density.size() < wanted) {
    const glm::uvec4& tet = mesh.tets[random() % mesh.tets.size()];
    const uint32_t a = tet[random() % 4], b = tet[random() % 4];
    if (a == b) continue;
    // The field is linear along an edge.
    samples.Add(0.5f * (mesh.positions[a] + mesh.positions[b]),
                0.5f * (field.color_srgb[a] + field.color_srgb[b]),
                0.5f * (field.density[a] + field.density[b]));
  }
  return MeshOf(samples);
}

RenderView LookingAt(const glm::dvec3& eye, const glm::dvec3& target, int width, int height,
                     double focal_px) {
  // Askew, so that no ray runs along an axis.
  const glm::dvec3 up(0.02, -0.97, 0.2);
  return {{width, height, focal_px, focal_px, 0.5 * width, 0.5 * height},
          CamLookingAt(eye, target, up)};
}

RenderView SquareView(const glm::dvec3& eye, const glm::dvec3& target, int size) {
  return LookingAt(eye, target, size, size, 1.25 * size);
}

std::vector<RenderView> ViewsAroundCube(int count, int size) {
  std::vector<RenderView> views;
  for (int i = 0; i < count; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / count, turn = i * std::numbers::phi * 2 * M_PI;
    const glm::dvec3 side(std::sqrt(1 - z * z) * std::cos(turn),
                          std::sqrt(1 - z * z) * std::sin(turn), z);
    views.push_back(SquareView(0.5 + 2.0 * side, glm::dvec3(0.5), size));
  }
  return views;
}

RenderView SquareMiddle(const RenderView& view, int size) {
  const double scale = double(size) / std::min(view.camera.width, view.camera.height);
  RenderView square = view;
  square.camera = {size,
                   size,
                   scale * view.camera.fx,
                   scale * view.camera.fy,
                   0.5 * size + scale * (view.camera.cx - 0.5 * view.camera.width),
                   0.5 * size + scale * (view.camera.cy - 0.5 * view.camera.height)};
  return square;
}

}  // namespace tetrec
