// Pictures of a field beside a photo.
#include "view/paint.h"

#include "core/random.h"
#include "mesh/delaunay.h"
#include "scratch_folder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace tetrec {
namespace {

constexpr int kWidth = 16, kHeight = 12;
constexpr glm::dvec3 kColor{0.5, 0.25, 0.75};

// An opaque box of one colour that fills the only camera's picture; its mesh has these vertices
// inside.
FieldContent OpaqueBox(const std::vector<glm::vec3>& inner = {}) {
  std::vector<glm::vec3> points;
  for (int i = 0; i < 8; ++i) {
    points.emplace_back((i & 1) ? 2 : -2, (i & 2) ? 2 : -2, (i & 4) ? 2 : 1);
  }
  points.insert(points.end(), inner.begin(), inner.end());
  FieldContent content;
  content.field.mesh = BuildDelaunay(points).mesh;
  content.field.density.assign(points.size(), 100.0f);
  content.field.color_srgb.assign(points.size(), glm::vec3(kColor));
  return content;
}

// The same with inner vertices that were moved without regard for tets.
FieldContent BrokenBox() {
  MersenneRandom random(1);
  const auto place = [&] {
    glm::vec3 at;
    for (int c = 0; c < 3; ++c) at[c] = float(random.Uniform());
    return at;
  };
  const glm::vec3 low(-1.9f, -1.9f, 1.05f), high(1.9f, 1.9f, 1.95f);
  std::vector<glm::vec3> inner;
  for (int i = 0; i < 100; ++i) inner.push_back(glm::mix(low, high, place()));
  FieldContent content = OpaqueBox(inner);
  for (glm::vec3& position : content.field.mesh.positions) {
    if (std::abs(position.x) == 2) continue;
    position = glm::clamp(position + 1.2f * (place() - 0.5f), low, high);
  }
  return content;
}

// The photo shows `color`.
ShownScene SceneWithPhoto(const ScratchFolder& folder, const glm::dvec3& color) {
  ShownScene shown{folder.path(), {}};
  shown.scene.cameras = {{kWidth, kHeight, 20, 20, 8, 6}};
  View view;
  view.name = "a.jpg";
  view.image = "a.png";
  shown.scene.views = {view};
  shown.scene.subject_bounds = {glm::dvec3(-1), glm::dvec3(1)};
  Image photo = MakeImage(kWidth, kHeight, 3);
  for (size_t i = 0; i < photo.pixels.size(); ++i) {
    photo.pixels[i] = uint8_t(std::lround(255 * color[int(i % 3)]));
  }
  WriteImage(folder / "a.png", photo);
  return shown;
}

PictureRequest RequestOf(PictureMode mode, const Scene& scene, int scale) {
  PictureRequest request;
  request.mode = mode;
  request.view = 0;
  const Camera& camera = scene.cameras[0];
  request.from = {{camera.width * scale, camera.height * scale, camera.fx * scale,
                   camera.fy * scale, camera.cx * scale, camera.cy * scale},
                  scene.views[0].cam_from_world};
  return request;
}

Image PaintNow(ShownField& field, const ShownScene& scene, const PictureRequest& request) {
  return Paint(field, scene, request, [] { return false; }).value();
}

RendererOptions Reference() {
  RendererOptions options;
  options.kind = RendererKind::kReference;
  return options;
}

// The share of pixels whose channels are all nearer to the colour than this.
double ShareNear(const Image& image, const glm::dvec3& color, double most) {
  int near = 0;
  for (size_t i = 0; i < image.pixels.size(); i += 3) {
    bool is_near = true;
    for (int c = 0; c < 3; ++c) {
      is_near = is_near && std::abs(image.pixels[i + size_t(c)] - 255 * color[c]) < most;
    }
    near += is_near;
  }
  return 3.0 * near / double(image.pixels.size());
}

int Brightest(const Image& image) {
  return *std::max_element(image.pixels.begin(), image.pixels.end());
}

TEST(Paint, TheErrorOfAPhotoLeavesItsExposureOut) {
  const ScratchFolder folder;
  const glm::dvec3 gain(0.5, 1.2, 0.8), offset(0.1, -0.05, 0.02);
  const ShownScene scene = SceneWithPhoto(folder, gain * kColor + offset);
  const PictureRequest request = RequestOf(PictureMode::kError, scene.scene, 1);
  FieldContent content = OpaqueBox();
  ShownField plain = MakeShownField(content, Reference());
  EXPECT_GT(Brightest(PaintNow(plain, scene, request)), 100);
  content.exposures = {{"other.jpg", glm::dvec3(3), {}}, {"a.jpg", gain, offset}};
  ShownField exposed = MakeShownField(content, Reference());
  // A level of rounding is a 64th of the range that the colours show, of which red is a third.
  EXPECT_LE(Brightest(PaintNow(exposed, scene, request)), 3 * 4);
  // Colours are shown at the mean exposure.
  const PictureRequest color = RequestOf(PictureMode::kColor, scene.scene, 1);
  EXPECT_EQ(PaintNow(exposed, scene, color).pixels, PaintNow(plain, scene, color).pixels);
}

// The mask is grey on the left and hides the right.
TEST(Paint, AGreyMaskDarkensNeitherThePhotoNorItsError) {
  const ScratchFolder folder;
  ShownScene scene = SceneWithPhoto(folder, kColor);
  scene.scene.has_masks = true;
  Image masked = MakeImage(kWidth, kHeight, 4);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      for (int c = 0; c < 3; ++c) masked.At(x, y)[c] = uint8_t(std::lround(255 * kColor[c]));
      masked.At(x, y)[3] = 2 * x < kWidth ? kSeenAlpha + 20 : kSeenAlpha - 20;
    }
  }
  WriteImage(folder / "a.png", masked);
  ShownField field = MakeShownField(OpaqueBox(), Reference());
  const Image photo = PaintNow(field, scene, RequestOf(PictureMode::kPhoto, scene.scene, 1));
  EXPECT_EQ(ShareNear(photo, kColor, 2), 0.5);
  const Image error = PaintNow(field, scene, RequestOf(PictureMode::kError, scene.scene, 1));
  EXPECT_EQ(ShareNear(error, glm::dvec3(0), 3 * 4 + 1), 0.5);
  EXPECT_EQ(ShareNear(error, glm::dvec3(0.5), 1), 0.5);
}

TEST(Paint, AnEnlargedPhotoHasNoHardPixels) {
  const ScratchFolder folder;
  const ShownScene scene = SceneWithPhoto(folder, kColor);
  Image photo = MakeImage(kWidth, kHeight, 3);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) std::fill_n(photo.At(x, y), 3, uint8_t(x % 2 ? 180 : 100));
  }
  WriteImage(folder / "a.png", photo);
  ShownField field = MakeShownField(OpaqueBox(), Reference());
  for (const PictureMode mode : {PictureMode::kPhoto, PictureMode::kError}) {
    const Image image = PaintNow(field, scene, RequestOf(mode, scene.scene, 10));
    ASSERT_EQ(image.width, 10 * kWidth);
    ASSERT_EQ(image.height, 10 * kHeight);
    int largest_step = 0;
    for (int x = 1; x < image.width; ++x) {
      largest_step = std::max(largest_step, std::abs(image.At(x, 60)[2] - image.At(x - 1, 60)[2]));
    }
    EXPECT_GT(largest_step, 5);
    EXPECT_LE(largest_step, 13);  // about a tenth of the step between two pixels
  }
}

TEST(Paint, ASliceShowsTheFieldInsideTheMeshAndGreyOutside) {
  const ScratchFolder folder;
  const ShownScene scene = SceneWithPhoto(folder, kColor);
  PictureRequest request = RequestOf(PictureMode::kSlice, scene.scene, 16);
  ShownField field = MakeShownField(OpaqueBox(), Reference());
  request.slice_depth = 1.5;
  EXPECT_EQ(ShareNear(PaintNow(field, scene, request), kColor, 4), 1.0);
  request.slice_depth = 3;
  EXPECT_EQ(ShareNear(PaintNow(field, scene, request), glm::dvec3(0.5), 1), 1.0);
}

TEST(Paint, ASliceThroughTetsThatAreInsideOutHasHardlyAnyHole) {
  const ScratchFolder folder;
  const ShownScene scene = SceneWithPhoto(folder, kColor);
  const FieldContent broken = BrokenBox();
  EXPECT_GT(CountDegenerateTets(broken.field.mesh), broken.field.mesh.tets.size() / 10);
  ShownField field = MakeShownField(broken, Reference());
  PictureRequest request = RequestOf(PictureMode::kSlice, scene.scene, 8);
  request.slice_depth = 1.5;
  request.from.camera.fx = request.from.camera.fy = 50;  // shows almost all of the plane
  const Image image = PaintNow(field, scene, request);
  EXPECT_GT(ShareNear(image, kColor, 4), 0.9);
  EXPECT_EQ(image.pixels, PaintNow(field, scene, request).pixels) << "depends on the threads";
}

TEST(Paint, EveryModeIsGivenUpForSomethingMoreUrgent) {
  const ScratchFolder folder;
  const ShownScene scene = SceneWithPhoto(folder, kColor);
  ShownField field = MakeShownField(OpaqueBox(), Reference());
  for (const Word<PictureMode>& mode : kWords<PictureMode>) {
    const PictureRequest request = RequestOf(mode.value, scene.scene, 16);
    EXPECT_FALSE(Paint(field, scene, request, [] { return true; })) << mode.word;
  }
  // The first question comes while depths are rendered, the second one while tets are painted.
  int questions = 0;
  const PictureRequest tets = RequestOf(PictureMode::kTets, scene.scene, 16);
  EXPECT_FALSE(Paint(field, scene, tets, [&] { return ++questions == 2; }));
  EXPECT_EQ(questions, 2);
  EXPECT_GT(Brightest(PaintNow(field, scene, tets)), 128) << "it is painted otherwise";
}

}  // namespace
}  // namespace tetrec
