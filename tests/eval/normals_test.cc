// Rendered normals against true normals.
#include "core/error.h"
#include "eval/evaluate_normals.h"
#include "eval/true_normals.h"
#include "expect_error.h"
#include "image/srgb.h"
#include "scratch_folder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace tetrec {
namespace {

constexpr Camera kFull{64, 48, 60, 60, 32, 24}, kHalf{32, 24, 30, 30, 16, 12};

// One normal everywhere in the data set's encoding, with background on the left, and a strip of
// another one on the right.
void WriteNerfNormals(const std::filesystem::path& path, const glm::dvec3& normal,
                      const glm::dvec3& strip) {
  Image map = MakeImage(kFull.width, kFull.height, 4);
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const glm::dvec3& shown = x < 56 ? normal : strip;
      for (int c = 0; c < 3; ++c) {
        const double level = x < 16 ? 0 : SrgbFromLinear(std::max(shown[c], 0.0));
        map.At(x, y)[c] = uint8_t(std::lround(255 * level));
      }
      map.At(x, y)[3] = 255;
    }
  }
  WriteImage(path, map);
}

// The camera looks along -z of the input frame.
const glm::dmat3 kInputFromCam(1, 0, 0, 0, -1, 0, 0, 0, -1);

TEST(NerfNormals, PositiveAndOneNegativeComponentAreFoundAtHalfTheSize) {
  const ScratchFolder folder;
  std::filesystem::create_directories(folder / "test");
  for (const glm::dvec3 n : {glm::dvec3(0, 0, 1), glm::dvec3(0.48, 0.6, 0.64),
                             glm::dvec3(-0.48, 0.6, 0.64), glm::dvec3(0.6, -0.48, 0.64)}) {
    WriteNerfNormals(folder / "test/r_1_normal_0001.png", n, {-0.6, -0.64, 0.48});
    const NormalMap map = ReadNerfNormals(folder.path(), "test/r_1", kHalf, kInputFromCam);
    for (int y = 0; y < map.height; ++y) {
      for (int x = 0; x < map.width; ++x) {
        // Beside the background, and where two components are negative, nothing is known.
        if (x < 9 || x >= 28) {
          EXPECT_EQ(map.At(x, y), glm::vec3(0.0f)) << x;
        } else {
          EXPECT_LT(glm::distance(glm::dvec3(map.At(x, y)), n), 0.02) << x;
        }
      }
    }
  }
  ExpectError<DataError>([&] { ReadNerfNormals(folder.path(), "test/r_2", kHalf, kInputFromCam); },
                         {"r_2_normal_", "test/r_2"});
}

TEST(NerfNormals, EdgesAndWhatFacesAwayAreUnknown) {
  const ScratchFolder folder;
  std::filesystem::create_directories(folder / "test");
  const std::filesystem::path file = folder / "test/r_1_normal_0001.png";
  WriteNerfNormals(file, {0, 0, 1}, {1, 0, 0});
  const NormalMap full = ReadNerfNormals(folder.path(), "test/r_1", kFull, kInputFromCam);
  EXPECT_GT(full.At(55, 24).z, 0.99f);
  const Camera shifted{63, 48, 60, 60, 31.5, 24};  // centres between the stored ones
  EXPECT_EQ(ReadNerfNormals(folder.path(), "test/r_1", shifted, kInputFromCam).At(55, 24),
            glm::vec3(0.0f));
  // Seen from below, a normal that points up cannot be.
  const glm::dmat3 from_below(1, 0, 0, 0, 1, 0, 0, 0, 1);
  EXPECT_EQ(ReadNerfNormals(folder.path(), "test/r_1", kFull, from_below).At(30, 24),
            glm::vec3(0.0f));
}

void ExpectScores(const std::optional<NormalScores>& scores, const NormalScores& expected) {
  ASSERT_TRUE(scores);
  EXPECT_EQ(scores->views, expected.views);
  EXPECT_EQ(scores->pixels, expected.pixels);
  EXPECT_EQ(scores->missing, expected.missing);
  EXPECT_NEAR(scores->mean_angle_deg, expected.mean_angle_deg, 1e-9);
  EXPECT_NEAR(scores->median_angle_deg, expected.median_angle_deg, 1e-9);
}

std::optional<NormalScores> NormalScoreOf(const NormalMap& rendered, const NormalMap& truth) {
  NormalAngles angles;
  angles.Add(rendered, truth);
  return std::move(angles).Score();
}

TEST(NormalAngles, AreOfPixelsThatHaveBoth) {
  NormalMap truth = MakeNormalMap(5, 1), rendered = truth;
  const glm::vec3 up(0, 0, 1), side(1, 0, 0), none(0.0f);
  truth.normal = {up, up, up, up, none};
  rendered.normal = {up, side, up, none, side};
  const auto scores = NormalScoreOf(rendered, truth);
  ExpectScores(scores, {.views = 1, .pixels = 3, .missing = 1, .mean_angle_deg = 30});
  EXPECT_EQ(NormalsJson(*scores)["pixels"], 3);
  EXPECT_FALSE(NormalScoreOf(MakeNormalMap(5, 1), truth));
  ExpectError<DataError>([&] { NormalScoreOf(MakeNormalMap(1, 5), truth); }, {"size"});
}

TEST(NormalAngles, ArePooledOverTheViewsThatHaveAny) {
  NormalMap truth = MakeNormalMap(2, 1), rendered = truth;
  const glm::vec3 up(0, 0, 1), side(1, 0, 0);
  NormalAngles angles;
  truth.normal = {up, up};
  rendered.normal = {up, side};
  angles.Add(rendered, truth);
  angles.Add(MakeNormalMap(2, 1), truth);
  angles.Add(rendered, rendered);
  const auto scores = std::move(angles).Score();
  ExpectScores(scores, {.views = 2, .pixels = 4, .missing = 2, .mean_angle_deg = 22.5});
}

}  // namespace
}  // namespace tetrec
