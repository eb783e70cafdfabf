// Which fits have signed density, and its scale.
#include "optimize/density_form.h"

#include "optimize/wavy_box.h"

#include <gtest/gtest.h>

#include <limits>

namespace tetrec {
namespace {

TEST(DensityForm, IsSignedForPicturesWithAlphaAndOnRequest) {
  const RadianceField box = WavyBox(0.4);
  RadianceField cells = box;
  cells.storage = FieldStorage::kCell;
  const auto is_signed = [](DensityForm form, bool has_alpha, const RadianceField& field) {
    return LearnedDensity(form, has_alpha, field).activation == Activation::kSigned;
  };
  EXPECT_TRUE(is_signed(DensityForm::kAuto, true, box));
  EXPECT_FALSE(is_signed(DensityForm::kAuto, false, box));
  EXPECT_FALSE(is_signed(DensityForm::kAuto, true, cells));
  EXPECT_TRUE(is_signed(DensityForm::kSigned, false, box));
  EXPECT_FALSE(is_signed(DensityForm::kPositive, true, box));
}

TEST(DensityOfSurfaces, MakesAFifthOfAnOpticalDepthOverTheMedianEdge) {
  TetMesh tet;
  tet.positions = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 0, 2}};
  tet.tets = {{0, 1, 2, 3}};
  // Three edges have a length of 2, and three are longer.
  EXPECT_NEAR(DensityOfSurfaces(tet), 0.2 / 2, 1e-6);
  EXPECT_EQ(DensityOfSurfaces(TetMesh()), std::numeric_limits<double>::infinity());
}

TEST(DensityForm, ScalesWithTheUnitOfTheWorld) {
  RadianceField box = WavyBox(0.4);
  const float scale = LearnedDensity(DensityForm::kSigned, true, box).scale;
  for (glm::vec3& position : box.mesh.positions) position *= 10.0f;
  EXPECT_NEAR(LearnedDensity(DensityForm::kSigned, true, box).scale, 0.1f * scale, 1e-5f * scale);
}

}  // namespace
}  // namespace tetrec
