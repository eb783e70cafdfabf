#include "eval/surface_pictures.h"

#include "scratch_folder.h"
#include "surface/draw_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace tetrec {
namespace {

const Camera kCamera{40, 30, 30.0, 30.0, 20.0, 15.0};

// A square in front of the camera, grey by its vertices, whose texture is red on the left and green
// on the right.
struct TexturedSquare {
  TriangleMesh mesh;
  Image texture = MakeImage(64, 64, 3);

  TexturedSquare() {
    mesh.positions = {{-1, 1, 3}, {1, 1, 3}, {1, -1, 3}, {-1, -1, 3}};
    mesh.colors_srgb.assign(4, {128, 128, 128});
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    const glm::vec2 a(0, 0), b(1, 0), c(1, 1), d(0, 1);
    mesh.corner_coordinates = {{a, b, c}, {a, c, d}};
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 64; ++x) texture.At(x, y)[x < 32 ? 0 : 1] = uint8_t(255 - 2 * y);
    }
  }
};

TEST(SurfacePictures, TheTextureIsDrawnUpright) {
  const TexturedSquare square;
  const SurfacePicture picture = DrawSurface(square.mesh, square.texture, kCamera, {});
  // The square covers pixels 10 to 30 and 5 to 25.
  const auto at = [&](int x, int y) { return picture.image.At(x, y); };
  EXPECT_NEAR(at(12, 8)[0], 255 - 2 * (8.5 - 5) * 64 / 20, 3);
  EXPECT_EQ(at(12, 8)[1], 0);
  EXPECT_NEAR(at(27, 22)[1], 255 - 2 * (22.5 - 5) * 64 / 20, 3);
  EXPECT_EQ(at(27, 22)[0], 0);
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 40; ++x) {
      EXPECT_EQ(picture.covered[size_t(y) * 40 + size_t(x)], x >= 10 && x < 30 && y >= 5 && y < 25)
          << x << ", " << y;
    }
  }
}

// The upper edge falls from row 5.0 at the left to 5.7 at the right: it leaves all 20 pixels of
// that row open, but rays may miss that.
TEST(SurfacePictures, MoreRaysFindThatAnEdgeLeavesPixelsOpen) {
  TriangleMesh mesh;
  mesh.positions = {{-1, 1, 3}, {1, 1, 3}, {1, -0.93, 3}, {-1, -1, 3}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  const auto covered = [&](int rays_per_side) {
    const SurfacePicture picture = DrawSurface(mesh, {}, kCamera, {}, rays_per_side);
    return std::ranges::count(picture.covered, true);
  };
  EXPECT_EQ(covered(2), 19 * 20 + 7);
  EXPECT_EQ(covered(4), 19 * 20 + 3);
}

// A picture of more rays than are in memory at once is drawn in parts.
TEST(SurfacePictures, PartsOfALargePictureFitTogether) {
  const TexturedSquare square;
  const Camera large = kCamera.Resized(1280, 960);
  const SurfacePicture picture = DrawSurface(square.mesh, square.texture, large, {}, 4);
  for (const int y : {200, 407, 408, 600, 700}) {
    for (const int x : {350, 500, 800, 950}) {
      const double texel_y = (y + 0.5 - 160) * 64 / 640;
      const int shown = x < 640 ? 0 : 1;
      EXPECT_NEAR(picture.image.At(x, y)[shown], 255 - 2 * (texel_y - 0.5), 0.6) << x << ", " << y;
      EXPECT_TRUE(picture.covered[size_t(y) * 1280 + size_t(x)]);
    }
  }
  EXPECT_EQ(std::ranges::count(picture.covered, true), 640 * 640);
}

TEST(SurfacePictures, ATextureScoresBetterThanVertexColoursAndOnlyWhereTheSurfaceIs) {
  const ScratchFolder folder;
  const TexturedSquare square;
  Scene scene;
  scene.cameras = {kCamera};
  scene.views = {{"a", "a.png", 0, {}, Split::kTest}, {"away", "b.png", 0, {}, Split::kTest}};
  scene.views[1].cam_from_world.translation = {0, 0, -9};  // the square is behind it
  // The truth differs from the square's picture by noise, and everywhere else by much.
  Image truth = DrawSurface(square.mesh, square.texture, kCamera, {}, kJudgingRaysPerSide).image;
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 40; ++x) {
      const bool inside = x >= 10 && x < 30 && y >= 5 && y < 25;
      for (int c = 0; c < 3; ++c) truth.At(x, y)[c] = uint8_t(inside ? truth.At(x, y)[c] ^ 1 : 200);
    }
  }
  const Image render = MakeImage(40, 30, 3);
  WriteImage(folder / "truth.png", truth);
  WriteImage(folder / "render.png", render);
  RenderedViews rendered;
  for (const View& view : scene.views) {
    RenderedView entry;
    entry.name = view.name;
    entry.truth = folder / "truth.png";
    entry.render = folder / "render.png";
    rendered.views.push_back(entry);
  }
  const auto pictures = ScoreSurfacePictures(square.mesh, square.texture, scene, rendered);
  ASSERT_TRUE(pictures);
  EXPECT_TRUE(pictures->textured);
  ASSERT_EQ(pictures->views.size(), 1);
  EXPECT_EQ(pictures->views_without_surface, std::vector<std::string>{"away"});
  EXPECT_NEAR(pictures->views[0].psnr, 20 * std::log10(255.0), 1e-6);  // off by 1 everywhere
  EXPECT_LT(pictures->views[0].vertex_color_psnr, 12);
  EXPECT_LT(pictures->views[0].field_psnr, 12);
  EXPECT_NEAR(pictures->views[0].covered, 400.0 / 1200, 1e-9);
  EXPECT_EQ(SurfacePicturesJson(*pictures)["psnr"], pictures->views[0].psnr);

  // Only pixels that count are covered: here those of the left half.
  Image seen = MakeImage(40, 30, 3);
  for (int y = 0; y < 30; ++y) std::fill_n(seen.At(0, y), 3 * 20, uint8_t{255});
  WriteImage(folder / "seen.png", seen);
  rendered.views[0].seen = folder / "seen.png";
  const auto half = ScoreSurfacePictures(square.mesh, square.texture, scene, rendered);
  EXPECT_NEAR(half->views[0].covered, 200.0 / 600, 1e-9);
  rendered.views[0].seen.reset();

  const auto plain = ScoreSurfacePictures(square.mesh, {}, scene, rendered);
  EXPECT_FALSE(plain->textured);
  EXPECT_EQ(plain->views[0].psnr, pictures->views[0].vertex_color_psnr);
}

}  // namespace
}  // namespace tetrec
