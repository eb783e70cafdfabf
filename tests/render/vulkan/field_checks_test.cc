// What renderers refuse: invalid fields, and fields that do not fit.
#include "render/field_checks.h"

#include "expect_error.h"
#include "render/scenes.h"
#include "render/seen_colors.h"
#include "render/vulkan/device_field.h"
#include "render/vulkan/device_memory.h"
#include "vulkan_test.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

namespace tetrec::test {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

class DoorTest : public EveryRendererTest {
 protected:
  void ExpectRefused(std::initializer_list<std::string> parts,
                     const std::function<void(RadianceField&)>& damage) {
    RadianceField field = RandomField(30, 91, 5.0f);
    damage(field);
    ExpectError<DataError>([&] { renderer().SetField(field); }, parts);
  }

  ProbedRenderer& renderer() {
    if (renderer_ == nullptr) renderer_ = &MakeRenderer();
    return *renderer_;
  }

 private:
  ProbedRenderer* renderer_ = nullptr;
};

INSTANTIATE_TEST_SUITE_P(Door, DoorTest, kEveryRenderer, RendererName);

uint32_t Inner(const TetMesh& mesh) {
  uint32_t t = 0;
  while (glm::any(glm::equal(mesh.neighbors[t], glm::uvec4(kNoTet)))) ++t;
  return t;
}

TEST_P(DoorTest, NamesTheTetOrVertexAndTheValue) {
  ExpectRefused({"no tet"}, [](RadianceField& f) { f = {}; });
  ExpectRefused({"tet 7 ", "inverted", "volume is -"},
                [](RadianceField& f) { std::swap(f.mesh.tets[7].x, f.mesh.tets[7].y); });
  ExpectRefused({"tet 1 ", "flat", "volume is 0"}, [](RadianceField& f) {
    f.mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {2, 2, 0}};
    f.mesh.tets = {{0, 1, 2, 3}, {0, 1, 2, 4}};
    f.mesh.neighbors.assign(2, glm::uvec4(kNoTet));
    f.density.assign(5, 1.0f);
    f.color_srgb.assign(5, glm::vec3(0.5f));
  });
  ExpectRefused({"vertex 38 belongs to no tet"}, [](RadianceField& f) {
    f.mesh.positions.emplace_back(0.0f);
    f.density.push_back(1.0f);
    f.color_srgb.emplace_back(0.5f);
  });
  ExpectRefused({"tet 3 names vertex 99 of 38"}, [](RadianceField& f) { f.mesh.tets[3].y = 99; });
  ExpectRefused({"tet 3 names neighbour 70000"},
                [](RadianceField& f) { f.mesh.neighbors[3].y = 70'000; });
  ExpectRefused({"no link back"}, [](RadianceField& f) {
    const uint32_t t = Inner(f.mesh);
    f.mesh.neighbors[t].z = kNoTet;
  });
  ExpectRefused({"links to"}, [](RadianceField& f) {
    const uint32_t t = Inner(f.mesh);
    std::swap(f.mesh.neighbors[t].x, f.mesh.neighbors[t].y);
  });
  ExpectRefused({"vertex 5 is not finite", "nan"},
                [](RadianceField& f) { f.mesh.positions[5].y = kNan; });
  ExpectRefused({"density of vertex 6", "nan"}, [](RadianceField& f) { f.density[6] = kNan; });
  ExpectRefused({"density of vertex 6", "inf"}, [](RadianceField& f) { f.density[6] = kInfinity; });
  ExpectRefused({"colour of vertex 4", "inf"},
                [](RadianceField& f) { f.color_srgb[4].g = -kInfinity; });
  ExpectRefused({"37 densities"}, [](RadianceField& f) { f.density.pop_back(); });
}

TEST_P(DoorTest, StatesOfTrainingAreCheckedToo) {
  const RadianceField field = RandomField(30, 92, 5.0f);
  const auto refused = [&](std::initializer_list<std::string> parts,
                           const std::function<void(FieldState&)>& damage) {
    FieldState state = StateOf(field);
    damage(state);
    ExpectError<DataError>([&] { renderer().SetState(field.mesh, state); }, parts);
  };
  refused({"vertex 9", "parameters", "log density is nan"},
          [](FieldState& s) { s.parameters[9 * 4 + 3] = kNan; });
  refused({"vertex 2", "first moments", "color[0] is inf"},
          [](FieldState& s) { s.first_moment[2 * 4] = kInfinity; });
  refused({"151 second moments", "38 vertices"}, [](FieldState& s) { s.second_moment.pop_back(); });
  refused({"153 parameters", "38 vertices"}, [](FieldState& s) { s.parameters.push_back(0.0f); });
  refused({"vertex 3", "second moments", "harmonics is nan"}, [](FieldState& s) {
    s = WithHarmonics(s, 1);
    s.second_moment[3 * 5 + 4] = kNan;
  });
  refused({"density"}, [](FieldState& s) { s.layout.attributes.pop_back(); });
}

TEST_P(DoorTest, TheFieldBeforeStaysWhereOneIsRefused) {
  const RadianceField field = RandomField(30, 93, 5.0f);
  renderer().SetField(field);
  const RenderView view = LookAt({1.7, -1.1, -1.0}, {0.0, 0.3, 0.6}, 16, 12);
  const RenderedImage before = renderer().Render(view, 1);
  RadianceField bad = field;
  bad.density[3] = kNan;
  EXPECT_THROW(renderer().SetField(bad), DataError);
  EXPECT_EQ(renderer().Render(view, 1).color_srgb, before.color_srgb);
}

TEST(CheckMemory, TellsNeededAndPresentBytes) {
  const TetMesh mesh = RandomBoxMesh(30, 94);
  EXPECT_NO_THROW(CheckMemory(mesh, 1000, {1000, "the host"}));
  ExpectError<EnvironmentError>(
      [&] {
        CheckMemory(mesh, 5'000'000, {4'999'999, "the host"});
      },
      {std::to_string(mesh.tets.size()) + " tets", "38 vertices", "needs 5000000 bytes",
       "the host has 4999999"});
}

using FieldMemoryTest = VulkanTest;

TEST_F(FieldMemoryTest, BytesAreThoseThatAnUploadTakes) {
  for (int points : {0, 200}) {
    for (bool fixed_point : {false, true}) {
      const TetMesh mesh = RandomBoxMesh(points, 95);
      const FieldState state =
          WithoutMoments({}, std::vector<float>(mesh.positions.size() * kStandardComponents));
      DeviceField field = UploadField(device(), mesh, state, fixed_point);
      AllocatePositionGradients(device(), field);
      uint64_t taken = 0;
      for (const Buffer* buffer :
           {&field.tets, &field.vertices, &field.hull, &field.parameters, &field.moments,
            &field.row_rates, &field.gradients, &field.position_gradients, &field.tet_scores}) {
        taken += buffer->bytes();
      }
      const uint64_t most =
          FieldBytes(mesh, state.layout, fixed_point, DevicePace().views_per_batch);
      EXPECT_GE(most, taken);
      EXPECT_LE(most, taken + 12 * 64);  // a box has 12 faces and no tree
    }
  }
}

TEST_F(FieldMemoryTest, MoreIsFreeThanASmallFieldNeeds) {
  const FreeMemory free = MeasureFreeMemory(device());
  EXPECT_GT(free.bytes, 1u << 20);
  EXPECT_LT(free.bytes, uint64_t{1} << 50);
  EXPECT_NE(free.of, "");
}

}  // namespace
}  // namespace tetrec::test
