// The segment integrals on the device against the same source compiled for C++ in double precision.
#include "gpu/commands.h"
#include "render/vulkan/integrator.h"
#include "shared/integral.glsl.h"
#include "test_shaders.h"
#include "vulkan_test.h"

#include <fmt/format.h>
#include <glm/glm.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace tetrec::test {
namespace {

// s0 and s1 from empty to opaque; in a fifth of the cases each, s0 is 0, s1 is 0, or both are
// almost equal.
std::vector<glm::vec2> SegmentEnds(int count) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> exponent(-8.0f, 3.0f);
  std::vector<glm::vec2> ends;
  for (int i = 0; i < count; ++i) {
    glm::vec2 s(std::pow(10.0f, exponent(random)), std::pow(10.0f, exponent(random)));
    if (i % 5 == 1) s.x = 0.0f;
    if (i % 5 == 2) s.y = 0.0f;
    if (i % 5 == 3) s.y = s.x * (1.0f + 1e-3f * std::exp(-float(i % 17)));
    ends.push_back(s);
  }
  return ends;
}

struct KernelResults {
  glm::vec4 weights, derivatives, functions;
};

std::vector<KernelResults> RunKernel(const Device& device, const std::vector<glm::vec2>& ends,
                                     const IntegralOptions& integral = {}) {
  const uint32_t count = uint32_t(ends.size());
  const Program program(device, "segment", kSegment, ConstantsOf(integral));
  Buffer in = MakeBuffer(device, "ends", ends),
         out(device, "results", sizeof(KernelResults) * count);
  CommandRecorder recorder(device);
  recorder.Begin();
  recorder.Dispatch(program, {{0, in}, {1, out}}, count, count);
  recorder.EndAndSubmit();
  recorder.Wait();
  return out.DownloadAs<KernelResults>(count);
}

double RelativeError(double value, double truth) {
  return truth == 0.0 ? std::abs(value) : std::abs(value - truth) / std::abs(truth);
}

// The fits, the quadrature and float rounding have an error of 8e-7 on the host (errata 2.5); the
// device's exp and division may be slightly less accurate.
constexpr double kWeightTolerance = 2e-6;

TEST_F(VulkanTest, SegmentWeightsOfTheKernelAreThoseOfTheReference) {
  const std::vector<glm::vec2> ends = SegmentEnds(20000);
  const auto results = RunKernel(device(), ends);
  double worst = 0;
  for (size_t i = 0; i < ends.size(); ++i) {
    const auto truth = IntegrateSegment(double(ends[i].x), double(ends[i].y));
    // A weight far below the opacity is lost in the rounding of the other.
    const double floor = 1e-3 * (truth.w0 + truth.w1);
    const double error =
        std::max(std::abs(results[i].weights.x - truth.w0) / std::max(truth.w0, floor),
                 std::abs(results[i].weights.y - truth.w1) / std::max(truth.w1, floor));
    worst = std::max(worst, error);
    ASSERT_LE(error, kWeightTolerance) << "s0 = " << ends[i].x << ", s1 = " << ends[i].y;
  }
  RecordProperty("worst_relative_error", fmt::format("{:.1e}", worst));
}

TEST_F(VulkanTest, SegmentDerivativesOfTheKernelAreThoseOfTheReference) {
  const std::vector<glm::vec2> ends = SegmentEnds(20000);
  const auto results = RunKernel(device(), ends);
  for (size_t i = 0; i < ends.size(); ++i) {
    const auto truth = IntegrateSegmentWithDerivatives(double(ends[i].x), double(ends[i].y));
    const KernelResults& r = results[i];
    const double scale = std::max({std::abs(truth.dw0_ds0), std::abs(truth.dw0_ds1),
                                   std::abs(truth.dw1_ds0), std::abs(truth.dw1_ds1)});
    // 16 nodes leave an error of 3e-6 on thick segments; the rest is float rounding of sums of
    // order 1.
    const double tolerance = 1e-5 * scale + 2e-7;
    ASSERT_NEAR(r.derivatives.x, truth.dw0_ds0, tolerance) << ends[i].x << " " << ends[i].y;
    ASSERT_NEAR(r.derivatives.y, truth.dw0_ds1, tolerance) << ends[i].x << " " << ends[i].y;
    ASSERT_NEAR(r.derivatives.z, truth.dw1_ds0, tolerance) << ends[i].x << " " << ends[i].y;
    ASSERT_NEAR(r.derivatives.w, truth.dw1_ds1, tolerance) << ends[i].x << " " << ends[i].y;
  }
}

const char* const kOtherIntegrals[] = {"mean", "split:1", "split:3", "split:4", "split:64"};

// split:3 and split:4 differ by more than these tolerances, which proves that the kernel got its
// specialization constants.
TEST_F(VulkanTest, OtherIntegralsOfTheKernelAreThoseOfTheReference) {
  const std::vector<glm::vec2> ends = SegmentEnds(5000);
  for (const char* words : kOtherIntegrals) {
    const IntegralOptions integral = ParseIntegral(words);
    const auto results = RunKernel(device(), ends, integral);
    // As on the host (segment_split.glsl.h), where n transmittances are rounded; exp may be
    // slightly less accurate.
    const double tolerance = 2e-6 + 2e-7 * integral.splits;
    for (size_t i = 0; i < ends.size(); ++i) {
      const auto truth = IntegrateSegmentByWithDerivatives(int(integral.kind), integral.splits,
                                                           double(ends[i].x), double(ends[i].y));
      SCOPED_TRACE(fmt::format("{}: {} {}", words, ends[i].x, ends[i].y));
      const KernelResults& r = results[i];
      const double opacity = truth.w0 + truth.w1;
      ASSERT_NEAR(r.weights.x, truth.w0, tolerance * opacity);
      ASSERT_NEAR(r.weights.y, truth.w1, tolerance * opacity);
      ASSERT_NEAR(r.weights.z, truth.w0, tolerance * opacity);
      ASSERT_NEAR(r.weights.w, truth.w1, tolerance * opacity);
      ASSERT_NEAR(r.derivatives.x, truth.dw0_ds0, tolerance);
      ASSERT_NEAR(r.derivatives.y, truth.dw0_ds1, tolerance);
      ASSERT_NEAR(r.derivatives.z, truth.dw1_ds0, tolerance);
      ASSERT_NEAR(r.derivatives.w, truth.dw1_ds1, tolerance);
    }
  }
}

// Vulkan allows errors of (3 + 2 |x|) units in the last place for exp, and of 2.5 and more for 1/x
// and sqrt.
TEST_F(VulkanTest, ElementaryFunctionsAreAsExactAsVulkanPromises) {
  const std::vector<glm::vec2> ends = SegmentEnds(20000);
  const auto results = RunKernel(device(), ends);
  double worst_exp = 0, worst_sqrt = 0, worst_reciprocal = 0;
  for (size_t i = 0; i < ends.size(); ++i) {
    const double x = ends[i].x;
    if (x <= 0.0 || x > 80.0) continue;
    const double ulp = 1.2e-7;
    const double error = RelativeError(results[i].functions.x, std::exp(-x));
    ASSERT_LE(error, (3.0 + 2.0 * x) * ulp) << "exp(-" << x << ")";
    worst_exp = std::max(worst_exp, error / (1.0 + x));
    worst_sqrt = std::max(worst_sqrt, RelativeError(results[i].functions.y, std::sqrt(x)));
    worst_reciprocal = std::max(worst_reciprocal, RelativeError(results[i].functions.z, 1.0 / x));
  }
  EXPECT_LE(worst_sqrt, 1e-6);
  EXPECT_LE(worst_reciprocal, 3.1e-7);
  RecordProperty("worst_exp_error_by_1_plus_x", fmt::format("{:.1e}", worst_exp));
}

}  // namespace
}  // namespace tetrec::test
