// Rays through volumes against closed forms and against plain summation in small steps.
#include "volume/ray_integrator.h"

#include "core/file.h"
#include "paths.h"
#include "volume/reader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>

namespace tetrec {
namespace {

// A step of 8-bit images.
constexpr double kStep = 1.0 / 255;
// Covers float sums over some hundred pieces of a ray (1e-5) and the colour tables (2.4e-4).
constexpr double kTolerance = 5e-4;
// Covers four nodes where a colour goes from black to white within one piece of a ray: sRGB is
// steep at black (the rule errs by 1.6e-3 for x^(1/2.4) on [0, 1], the worst case for a piece, and
// the weights of the pieces sum to 1).
constexpr double kSteepTolerance = 0.6 * kStep;

const Similarity3 kUnmoved;

TransferFunction MakeFunction(std::vector<TransferFunction::OpacityPoint> opacity,
                              std::vector<TransferFunction::ColorPoint> color) {
  return {std::move(opacity), std::move(color), ColorInterpolation::kLinearRgb};
}

// A jagged function that shows nothing below 0.3.
TransferFunction Jagged() {
  return MakeFunction({{0, 0}, {0.3, 0}, {0.45, 0.8}, {0.5, 0.1}, {0.9, 1}, {1, 0}},
                      {{0, {0, 1, 0}}, {0.4, {1, 0.2, 0}}, {0.7, {0, 0, 1}}, {1, {1, 1, 1}}});
}

Volume MakeVolume(const glm::ivec3& size, const glm::dvec3& spacing) {
  Volume volume{size, spacing, glm::dvec3(0.0)};
  volume.samples.assign(size_t(size.x) * size_t(size.y) * size_t(size.z), 0);
  return volume;
}

Volume RandomVolume(const glm::ivec3& size, const glm::dvec3& spacing, uint64_t seed) {
  Volume volume = MakeVolume(size, spacing);
  std::mt19937_64 generator(seed);
  for (float& sample : volume.samples) sample = float(double(generator() >> 11) * 0x1p-53);
  return volume;
}

struct Ray {
  glm::dvec3 origin, direction;
};

// Rays that start outside the volume; some of them miss it.
std::vector<Ray> RandomRays(const Volume& volume, int count, uint64_t seed) {
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(-0.1, 1.1);
  std::vector<Ray> rays;
  for (int i = 0; i < count; ++i) {
    const glm::dvec3 side =
        glm::normalize(glm::dvec3(normal(generator), normal(generator), normal(generator)));
    const glm::dvec3 target =
        volume.origin +
        glm::dvec3(uniform(generator), uniform(generator), uniform(generator)) * volume.Extent();
    rays.push_back({target + 2 * glm::length(volume.Extent()) * side, -side});
  }
  return rays;
}

// The part of a ray inside the volume's box; begin > end if it misses the box.
struct Span {
  double begin, end;
};
Span SpanOf(const Volume& volume, const Ray& ray) {
  Span span{0, 1e9};
  for (int axis = 0; axis < 3; ++axis) {
    double a = (volume.origin[axis] - ray.origin[axis]) / ray.direction[axis];
    double b =
        (volume.origin[axis] + volume.Extent()[axis] - ray.origin[axis]) / ray.direction[axis];
    if (a > b) std::swap(a, b);
    span.begin = std::max(span.begin, a);
    span.end = std::min(span.end, b);
  }
  return span;
}

// Density (in x) and colour at a point, directly from the definition.
glm::dvec4 FieldAt(const Volume& volume, const TransferFunction& function, double density,
                   Shading shading, const glm::dvec3& point) {
  const glm::dvec3 at = (point - volume.origin) / volume.spacing;
  const glm::ivec3 cell = glm::clamp(glm::ivec3(glm::floor(at)), glm::ivec3(0), volume.size - 2);
  const auto shade = [&](double sample) {
    return glm::dvec4(density * function.OpacityAt(sample), function.SrgbAt(sample));
  };
  double sample = 0;
  glm::dvec4 shaded(0.0);
  for (int corner = 0; corner < 8; ++corner) {
    const glm::ivec3 i = cell + glm::ivec3(corner & 1, corner >> 1 & 1, corner >> 2);
    const glm::dvec3 distance = glm::abs(at - glm::dvec3(i));
    const double weight = (1 - distance.x) * (1 - distance.y) * (1 - distance.z);
    const double value =
        volume.samples[(size_t(i.z) * size_t(volume.size.y) + size_t(i.y)) * size_t(volume.size.x) +
                       size_t(i.x)];
    sample += weight * value;
    if (shading == Shading::kPre) shaded += weight * shade(value);
  }
  return shading == Shading::kPre ? shaded : shade(glm::clamp(sample, 0.0, 1.0));
}

// Sums many small steps of constant density and colour.
glm::dvec4 SumInSteps(const Volume& volume, const TransferFunction& function, double density,
                      Shading shading, const Ray& ray, double step) {
  const Span span = SpanOf(volume, ray);
  if (!(span.begin < span.end)) return glm::dvec4(0.0);
  const int count = int(std::ceil((span.end - span.begin) / step));
  const double size = (span.end - span.begin) / count;
  glm::dvec3 color(0.0);
  double depth = 0;
  for (int i = 0; i < count; ++i) {
    const glm::dvec4 field = FieldAt(volume, function, density, shading,
                                     ray.origin + (span.begin + (i + 0.5) * size) * ray.direction);
    color +=
        std::exp(-depth) * -std::expm1(-field.x * size) * glm::dvec3(field.y, field.z, field.w);
    depth += field.x * size;
  }
  return {color, -std::expm1(-depth)};
}

double Difference(const GatheredColor& gathered, const glm::dvec4& expected) {
  const glm::dvec4 error =
      glm::abs(glm::dvec4(gathered.premultiplied_srgb, gathered.alpha) - expected);
  return std::max({error.x, error.y, error.z, error.w});
}

TEST(RayIntegrator, AConstantVolumeHidesByItsChord) {
  Volume volume = MakeVolume({5, 9, 7}, {1, 0.5, 0.7});
  std::fill(volume.samples.begin(), volume.samples.end(), 0.5f);
  const glm::dvec3 color(0.2, 0.6, 1);
  const TransferFunction function = MakeFunction({{0.5, 0.5}}, {{0.5, color}});
  for (const double density : {0.01, 1.0, 1000.0}) {
    for (const Shading shading : {Shading::kPre, Shading::kPost}) {
      const RayIntegrator rays(volume, function, density, shading, kUnmoved);
      int misses = 0;
      for (const Ray& ray : RandomRays(volume, 300, 1)) {
        const Span span = SpanOf(volume, ray);
        const double alpha = -std::expm1(-0.5 * density * std::max(0.0, span.end - span.begin));
        misses += alpha == 0 ? 1 : 0;
        // The transmittance at which a ray stops, and the nodes' error for parts of depth 1 (2e-5).
        EXPECT_LT(
            Difference(rays.Gather(ray.origin, ray.direction), glm::dvec4(alpha * color, alpha)),
            2 * RayIntegrator::kStopTransmittance);
      }
      EXPECT_GT(misses, 0);
      EXPECT_LT(misses, 200);
    }
  }
}

TEST(RayIntegrator, ARampIsIntegratedThroughTheKnotsOfTheTransferFunction) {
  Volume volume = MakeVolume({4, 2, 2}, glm::dvec3(1.0));  // samples rise by 1/3 per cell along x
  for (size_t i = 0; i < volume.samples.size(); ++i) volume.samples[i] = float(i % 4) / 3;
  const TransferFunction function = Jagged();
  const RayIntegrator rays(volume, function, 3, Shading::kPost, kUnmoved);
  // The sample is x / 3 along the ray, so the transfer function itself is integrated.
  constexpr int kSteps = 300000;
  glm::dvec3 color(0.0);
  double depth = 0;
  for (int i = 0; i < kSteps; ++i) {
    const double sample = (i + 0.5) / kSteps, own = 3 * function.OpacityAt(sample) * 3 / kSteps;
    color += std::exp(-depth) * -std::expm1(-own) * function.SrgbAt(sample);
    depth += own;
  }
  EXPECT_LT(
      Difference(rays.Gather({-1, 0.3, 0.6}, {1, 0, 0}), glm::dvec4(color, -std::expm1(-depth))),
      kTolerance);
}

TEST(RayIntegrator, NoiseAgreesWithSmallSteps) {
  const TransferFunction function = Jagged();
  for (const Shading shading : {Shading::kPre, Shading::kPost}) {
    for (const double density : {0.3, 5.0}) {
      const Volume volume = RandomVolume({7, 6, 9}, {1, 1.3, 0.8}, 2);
      const RayIntegrator rays(volume, function, density, shading, kUnmoved);
      for (const Ray& ray : RandomRays(volume, 60, 3)) {
        const glm::dvec4 expected = SumInSteps(volume, function, density, shading, ray, 1.0 / 400);
        EXPECT_LT(Difference(rays.Gather(ray.origin, ray.direction), expected),
                  shading == Shading::kPre ? kTolerance : kSteepTolerance)
            << Name(shading) << " " << density;
      }
    }
  }
}

TEST(RayIntegrator, RaysAlongAxesAndInTheGridsPlanesAgreeWithSmallSteps) {
  const TransferFunction function = Jagged();
  const Volume volume = RandomVolume({6, 6, 6}, glm::dvec3(1.0), 4);
  const std::vector<Ray> degenerate = {
      {{-1, 2, 3}, {1, 0, 0}},
      {{2, 7, 2.5}, {0, -1, 0}},
      {{0, 0, -1}, {0, 0, 1}},
      {{5, 5, 9}, {0, 0, -1}},
      {{-1, -1, 2}, glm::normalize(glm::dvec3(1, 1, 0))},
      {{6, 6, 6}, -glm::normalize(glm::dvec3(1, 1, 1))},
  };
  for (const Shading shading : {Shading::kPre, Shading::kPost}) {
    const RayIntegrator rays(volume, function, 1, shading, kUnmoved);
    for (const Ray& ray : degenerate) {
      // The sum is along a slightly shifted ray inside the box, with no component of 0.
      Ray beside = ray;
      beside.origin += 1e-7 * (glm::dvec3(2.5) - ray.origin);
      beside.direction = glm::normalize(ray.direction + glm::dvec3(1.1e-9, 1.2e-9, 1.3e-9));
      const glm::dvec4 expected = SumInSteps(volume, function, 1, shading, beside, 1.0 / 400);
      EXPECT_GT(expected.w, 0.1);
      EXPECT_LT(Difference(rays.Gather(ray.origin, ray.direction), expected),
                shading == Shading::kPre ? kTolerance : kSteepTolerance);
    }
    EXPECT_EQ(rays.Gather({-1, 5.001, 3}, {1, 0, 0}).alpha, 0);
    EXPECT_EQ(rays.Gather({6, 2, 3}, {1, 0, 0}).alpha, 0);  // behind the origin
  }
}

TEST(RayIntegrator, EmptySpaceIsSkippedWithoutLosingWhatIsBehind) {
  const TransferFunction function = Jagged();
  Volume volume = MakeVolume({23, 30, 19}, glm::dvec3(1.0));
  std::mt19937_64 generator(5);
  for (int i = 0; i < 60; ++i) {  // isolated samples, each in eight visible cells
    volume.samples[size_t(generator() % volume.samples.size())] = 0.9f;
  }
  for (const Shading shading : {Shading::kPre, Shading::kPost}) {
    const RayIntegrator rays(volume, function, 4, shading, kUnmoved);
    int seen = 0;
    for (const Ray& ray : RandomRays(volume, 400, 6)) {
      const glm::dvec4 expected = SumInSteps(volume, function, 4, shading, ray, 1.0 / 100);
      seen += expected.w > 0.01 ? 1 : 0;
      EXPECT_LT(Difference(rays.Gather(ray.origin, ray.direction), expected), kSteepTolerance);
    }
    EXPECT_GT(seen, 20);
  }
}

TEST(RayIntegrator, KnowsWhetherThereIsAnythingToSee) {
  // Opaque between 0.25 and 0.75, which float holds exactly.
  const TransferFunction function =
      MakeFunction({{0.25, 0}, {0.5, 1}, {0.75, 0}}, {{0, {0.3, 0.5, 0.7}}});
  struct Case {
    float most, lone;  // the value of all but one of 378 samples, and of that one
    bool pre, post;
    size_t dense;
  };
  const Case cases[] = {
      {0, 0, false, false, 0},         {0, 0.2f, false, false, 0},
      {0.1f, 0.25f, false, false, 0},  // up to where opacity begins
      {0.25f, 0.25f, false, false, 0}, {0.75f, 1, false, false, 0},
      {0, 0.26f, true, true, 1},       {0.74f, 1, true, true, 377},
      {0, 1, false, true, 0},  // only the values between two samples
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(std::to_string(c.most) + " and " + std::to_string(c.lone));
    Volume volume = MakeVolume({9, 7, 6}, glm::dvec3(1.0));
    std::fill(volume.samples.begin(), volume.samples.end(), c.most);
    volume.samples[200] = c.lone;
    const RayIntegrator pre(volume, function, 1, Shading::kPre, kUnmoved);
    const RayIntegrator post(volume, function, 1, Shading::kPost, kUnmoved);
    EXPECT_EQ(pre.AnythingVisible(), c.pre);
    EXPECT_EQ(post.AnythingVisible(), c.post);
    EXPECT_EQ(pre.CountDense(), c.dense);
    EXPECT_EQ(post.CountDense(), c.dense);
  }
}

TEST(RayIntegrator, BothShadingsAgreeForALinearTransferFunction) {
  const TransferFunction function = MakeFunction({{0, 0}, {1, 1}}, {{0, {0.3, 0.5, 0.7}}});
  const Volume volume = RandomVolume({5, 8, 6}, {1, 0.6, 0.9}, 7);
  const RayIntegrator pre(volume, function, 2, Shading::kPre, kUnmoved);
  const RayIntegrator post(volume, function, 2, Shading::kPost, kUnmoved);
  for (const Ray& ray : RandomRays(volume, 200, 8)) {
    const GatheredColor a = pre.Gather(ray.origin, ray.direction);
    EXPECT_LT(Difference(post.Gather(ray.origin, ray.direction),
                         glm::dvec4(a.premultiplied_srgb, a.alpha)),
              1e-5);  // roundings of float
  }
}

TEST(RayIntegrator, GivesTheSameResultWhereverTheVolumeIs) {
  const TransferFunction function = Jagged();
  Volume volume = RandomVolume({5, 5, 5}, glm::dvec3(1.0), 9);
  volume.origin = {10, -4, 3};
  const Similarity3 world_from_volume{0.25, glm::dmat3(1.0), {1, 2, 3}};
  const RayIntegrator here(volume, function, 1, Shading::kPost, kUnmoved);
  const RayIntegrator there(volume, function, 1 / 0.25, Shading::kPost, world_from_volume);
  for (const Ray& ray : RandomRays(volume, 100, 10)) {
    const GatheredColor a = here.Gather(ray.origin, ray.direction);
    EXPECT_LT(Difference(there.Gather(world_from_volume * ray.origin, ray.direction),
                         glm::dvec4(a.premultiplied_srgb, a.alpha)),
              1e-4);
  }
}

TEST(RenderVolume, WritesStraightAlpha) {
  Volume volume = MakeVolume({2, 2, 2}, glm::dvec3(1.0));
  const TransferFunction function = MakeFunction({{0, 1}}, {{0, {1, 0.5, 0}}});
  const RayIntegrator rays(volume, function, std::log(2.0), Shading::kPre, kUnmoved);
  // Through the middle along z, half of the light is absorbed.
  const Camera camera{3, 1, 1, 1, 1.5, 0.5};
  const Image image = RenderVolume(rays, camera, {glm::dmat3(1.0), glm::dvec3(-0.5, -0.5, 3)}, 1);
  EXPECT_EQ(image.channels, 4);
  const uint8_t* middle = image.At(1, 0);
  EXPECT_EQ(int(middle[0]), 255);
  EXPECT_EQ(int(middle[1]), 128);
  EXPECT_EQ(int(middle[2]), 0);
  EXPECT_EQ(int(middle[3]), 128);
  EXPECT_EQ(int(image.At(0, 0)[3]), 0);
}

// The real data, if available: TETREC_DATASETS, or beside the project.
class Tooth : public ::testing::TestWithParam<Shading> {
 protected:
  void SetUp() override {
    const std::filesystem::path folder = test::DatasetsFolder() / "volumes";
    const std::filesystem::path raw = folder / "tooth_103x94x161_uint8.raw";
    if (!std::filesystem::exists(raw)) {
      GTEST_SKIP() << "no volume at " << raw << " (TETREC_DATASETS)";
    }
    VolumeLayout layout;
    layout.size = {103, 94, 161};
    volume_ = ReadRawVolume(raw, layout).volume;
    function_ = ReadTransferFunction(folder / "tooth3gauss.json", {0, 255});
  }
  // 50 along the longest side, in units of cells.
  double Density() const { return 50 / volume_.Extent().z; }

  Volume volume_;
  TransferFunction function_;
};

TEST_P(Tooth, IsAccurateToLessThanAStepOfEightBits) {
  const RayIntegrator rays(volume_, function_, Density(), GetParam(), kUnmoved);
  double largest = 0;
  for (const Ray& ray : RandomRays(volume_, 100, 11)) {
    const glm::dvec4 expected = SumInSteps(volume_, function_, Density(), GetParam(), ray, 0.02);
    largest = std::max(largest, Difference(rays.Gather(ray.origin, ray.direction), expected));
  }
  RecordProperty("largest_error_times_255", std::to_string(255 * largest));
  EXPECT_LT(largest, 0.25 * kStep);
}

TEST_P(Tooth, PartsTenTimesFinerChangeNothing) {
  const RayIntegrator rays(volume_, function_, Density(), GetParam(), kUnmoved);
  double largest = 0;
  for (const Ray& ray : RandomRays(volume_, 5000, 12)) {
    const GatheredColor finer = rays.Gather(ray.origin, ray.direction, 10);
    largest = std::max(largest, Difference(rays.Gather(ray.origin, ray.direction),
                                           glm::dvec4(finer.premultiplied_srgb, finer.alpha)));
  }
  RecordProperty("largest_difference_times_255", std::to_string(255 * largest));
  EXPECT_LT(largest, 0.1 * kStep);
}

INSTANTIATE_TEST_SUITE_P(Shadings, Tooth, ::testing::Values(Shading::kPre, Shading::kPost),
                         [](const auto& shading) { return std::string(Name(shading.param)); });

}  // namespace
}  // namespace tetrec
