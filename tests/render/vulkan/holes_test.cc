// Meshes with holes, cavities and several parts: what pruning leaves of a Delaunay mesh.
#include "expect_error.h"
#include "render/reference_loss.h"
#include "render/scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace tetrec::test {
namespace {

// The tets of a field for which keep(tet, centroid) is true, with their vertices.
RadianceField Kept(const RadianceField& field,
                   const std::function<bool(uint32_t, const glm::vec3&)>& keep) {
  RadianceField kept;
  std::vector<uint32_t> new_id(field.mesh.positions.size(), kNoTet);
  for (uint32_t t = 0; t < field.mesh.tets.size(); ++t) {
    glm::uvec4 tet = field.mesh.tets[t];
    glm::vec3 centroid(0.0f);
    for (int i = 0; i < 4; ++i) centroid += 0.25f * field.mesh.positions[tet[i]];
    if (!keep(t, centroid)) continue;
    for (int i = 0; i < 4; ++i) {
      uint32_t& id = new_id[tet[i]];
      if (id == kNoTet) {
        id = uint32_t(kept.density.size());
        kept.mesh.positions.push_back(field.mesh.positions[tet[i]]);
        kept.density.push_back(field.density[tet[i]]);
        kept.color_srgb.push_back(field.color_srgb[tet[i]]);
      }
      tet[i] = id;
    }
    kept.mesh.tets.push_back(tet);
  }
  kept.mesh.neighbors = ComputeNeighbors(kept.mesh.tets, kept.mesh.positions.size());
  CheckTetMesh(kept.mesh);
  return kept;
}

RadianceField ThirdRemoved(const RadianceField& field) {
  std::mt19937 random(81);
  return Kept(field, [&](uint32_t, const glm::vec3&) { return random() % 3 != 0; });
}

const glm::vec3 kMiddle = 0.5f * (kBoxMin + kBoxMax);

RadianceField WithCavity(const RadianceField& field) {
  return Kept(field,
              [](uint32_t, const glm::vec3& p) { return glm::distance(p, kMiddle) > 0.25f; });
}

RadianceField TwoParts(const RadianceField& field) {
  return Kept(field,
              [](uint32_t, const glm::vec3& p) { return std::abs(p.y - kMiddle.y) > 0.15f; });
}

// Every second tet around a vertex: they share vertices and edges, but hardly any face.
RadianceField EverySecond(const RadianceField& field) {
  std::vector<uint8_t> kept(field.mesh.tets.size(), 0);
  return Kept(field, [&](uint32_t t, const glm::vec3&) {
    for (int i = 0; i < 4; ++i) {
      const uint32_t neighbor = field.mesh.neighbors[t][i];
      if (neighbor != kNoTet && kept[neighbor]) return false;
    }
    kept[t] = 1;
    return true;
  });
}

// Two tets that share one vertex, and one that shares an edge with the first.
RadianceField ThreeTets() {
  RadianceField field;
  field.mesh.positions = {{0.01f, 0.22f, 0.53f}, {0.4f, 0.19f, 0.5f},  {0.03f, 0.6f, 0.47f},
                          {0.02f, 0.24f, 0.9f},  {-0.4f, 0.1f, 0.52f}, {0.02f, -0.2f, 0.45f},
                          {-0.1f, 0.2f, 0.3f},   {0.5f, -0.2f, 0.6f},  {0.1f, -0.1f, 0.8f}};
  field.mesh.tets = {{0, 1, 2, 3}, {0, 4, 5, 6}, {0, 1, 7, 8}};
  for (glm::uvec4& tet : field.mesh.tets) {
    const auto& p = field.mesh.positions;
    if (glm::dot(p[tet[1]] - p[tet[0]], glm::cross(p[tet[2]] - p[tet[0]], p[tet[3]] - p[tet[0]])) <
        0) {
      std::swap(tet[2], tet[3]);
    }
  }
  field.mesh.neighbors = ComputeNeighbors(field.mesh.tets, 9);
  CheckTetMesh(field.mesh);
  for (int v = 0; v < 9; ++v) {
    field.density.push_back(1.0f + float(v));
    field.color_srgb.emplace_back(0.1f * float(v), 1.0f - 0.1f * float(v), 0.5f);
  }
  return field;
}

struct NamedField {
  const char* name;
  RadianceField field;
};

std::vector<NamedField> Fields(float max_density) {
  const RadianceField small = RandomField(20, 82, max_density);
  const RadianceField large = RandomField(250, 83, max_density);
  return {{"three tets", ThreeTets()},
          {"20 points, a third removed", ThirdRemoved(small)},
          {"250 points, a third removed", ThirdRemoved(large)},
          {"a cavity", WithCavity(large)},
          {"two parts", TwoParts(large)},
          {"every second tet", EverySecond(large)}};
}

// Two views from outside and some from inside, in the cavity or the gap if there is one.
std::vector<RenderView> Views(int width, int height) {
  std::vector<RenderView> views = ThreeViews(width, height);
  const glm::dvec3 middle(kMiddle);
  views.push_back(LookAt(middle, middle + glm::dvec3(0.3, 0.9, 0.2), width, height, 0.5));
  views.push_back(LookAt(middle + glm::dvec3(0.4, 0.02, 0.1), middle, width, height, 0.5));
  return views;
}

class HolesTest : public EveryRendererTest {};

INSTANTIATE_TEST_SUITE_P(Holes, HolesTest,
                         ::testing::Values(RendererKind::kMarch, RendererKind::kPpll),
                         RendererName);

TEST_P(HolesTest, PicturesAreThoseOfTheReference) {
  for (float stop : {0.0f, 1e-3f}) {
    ProbedRenderer& renderer = MakeRenderer({.stop_transmittance = stop});
    for (const NamedField& named : Fields(10.0f)) {
      renderer.SetField(named.field);
      int number = 0;
      for (const RenderView& view : Views(29, 21)) {
        const RenderedImage image = renderer.Render(view, 1);
        const ReferenceImage truth = RenderReference(named.field, view, stop);
        for (size_t i = 0; i < truth.color_srgb.size(); ++i) {
          ASSERT_NEAR(glm::distance(glm::dvec3(image.color_srgb[i]), truth.color_srgb[i]), 0.0,
                      kPictureTolerance)
              << named.name << ", view " << number << ", pixel " << i;
          ASSERT_NEAR(image.transmittance[i], std::exp(-truth.optical_depth[i]), kPictureTolerance)
              << named.name << ", view " << number << ", pixel " << i;
        }
        ++number;
      }
      EXPECT_EQ(renderer.counts().lost_rays, 0u) << named.name;
    }
  }
}

TEST_F(RendererTest, ProjectionInExactOrderRefusesMeshesWithHolesAndNamesTheOthers) {
  RendererOptions options{.kind = RendererKind::kProjection};
  ProbedRenderer& exact = MakeRenderer(options);
  options.order = VisibilityOrder::kCentroid;
  ProbedRenderer& centroid = MakeRenderer(options);
  for (const NamedField& named : Fields(10.0f)) {
    ExpectError<DataError>([&] { exact.SetField(named.field); },
                           {"not convex", "'march'", "'ppll'", "order 'centroid'"});
    EXPECT_NO_THROW(centroid.SetField(named.field)) << named.name;
  }
}

double Norm(const std::vector<glm::dvec3>& values) {
  double sum = 0;
  for (const glm::dvec3& value : values) sum += glm::dot(value, value);
  return std::sqrt(sum);
}

template <class A, class B>
std::vector<glm::dvec3> Differences(const std::vector<A>& a, const std::vector<B>& b) {
  std::vector<glm::dvec3> result;
  for (size_t i = 0; i < a.size(); ++i) result.push_back(glm::dvec3(a[i]) - glm::dvec3(b[i]));
  return result;
}

void ExpectSameGradient(const ProbedRenderer& renderer, const FieldGradient& gradient,
                        const ReferenceGradient& truth) {
  // Hundreds of rays are added in float, in any order.
  EXPECT_LE(Norm(Differences(gradient.color_srgb, truth.color_srgb)),
            3e-5 * Norm(truth.color_srgb));
  EXPECT_LE(Norm(Differences(gradient.density, truth.density)),
            3e-5 * Norm(Differences(truth.density, std::vector<double>(truth.density.size()))));
  if (gradient.position.empty()) return;
  // As in position_gradient_test: faces seen at a flat angle magnify rounding (to 1.5e-4 on an
  // H100).
  const double tolerance = IsOfSoftware(renderer) ? 1e-4 : 3e-4;
  EXPECT_LE(Norm(Differences(gradient.position, truth.position)), tolerance * Norm(truth.position));
  EXPECT_LE(Norm(Differences(gradient.absolute_position, truth.absolute_position)),
            tolerance * Norm(Differences(truth.absolute_position,
                                         std::vector<double>(truth.density.size()))));
}

TEST_P(HolesTest, GradientsAreThoseOfTheReferenceWithEitherKindOfAtomics) {
  for (bool float_atomics : {true, false}) {
    for (float stop : {0.0f, 1e-3f}) {
      ProbedRenderer& renderer =
          MakeRenderer({.device = {.float_atomics = float_atomics}, .stop_transmittance = stop});
      for (const NamedField& named : Fields(10.0f)) {
        renderer.SetField(named.field);
        int number = 0;
        for (const RenderView& view : Views(21, 15)) {
          SCOPED_TRACE(::testing::Message() << named.name << ", view " << number++ << ", stop "
                                            << stop << ", atomics " << float_atomics);
          const std::vector<glm::dvec4> g = RandomPixelGradient(view.camera, 84);
          const FieldGradient gradient =
              renderer.Backpropagate(view, std::vector<glm::vec4>(g.begin(), g.end()),
                                     GradientParts::kColorDensityPosition);
          ExpectSameGradient(renderer, gradient,
                             BackpropagateReference(named.field, view, g, stop));
        }
      }
    }
  }
}

}  // namespace
}  // namespace tetrec::test
