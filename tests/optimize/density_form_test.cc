// What density is learned by, and its scale.
#include "optimize/density_form.h"

#include "optimize/wavy_box.h"

#include <gtest/gtest.h>

#include <limits>

namespace tetrec {
namespace {

TEST(DensityForm, FollowsThePicturesUnlessItIsGiven) {
  const RadianceField box = WavyBox(0.4);
  RadianceField cells = box;
  cells.storage = FieldStorage::kCell;
  const auto activation = [](DensityForm form, bool has_alpha, const RadianceField& field) {
    return LearnedDensity(form, has_alpha, field).activation;
  };
  EXPECT_EQ(activation(DensityForm::kAuto, true, box), Activation::kSigned);
  EXPECT_EQ(activation(DensityForm::kAuto, false, box), Activation::kExp);
  EXPECT_EQ(activation(DensityForm::kAuto, true, cells), Activation::kExp);
  EXPECT_EQ(activation(DensityForm::kAuto, false, cells), Activation::kExp);
  EXPECT_EQ(activation(DensityForm::kSigned, false, box), Activation::kSigned);
  EXPECT_EQ(activation(DensityForm::kSoftplus, true, box), Activation::kSoftplus);
  EXPECT_EQ(activation(DensityForm::kPositive, true, box), Activation::kExp);
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
  for (const DensityForm form : {DensityForm::kSigned, DensityForm::kSoftplus}) {
    RadianceField box = WavyBox(0.4);
    const float scale = LearnedDensity(form, true, box).scale;
    for (glm::vec3& position : box.mesh.positions) position *= 10.0f;
    EXPECT_NEAR(LearnedDensity(form, true, box).scale, 0.1f * scale, 1e-5f * scale);
  }
}

}  // namespace
}  // namespace tetrec
