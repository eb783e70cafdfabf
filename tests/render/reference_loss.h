// A loss that is linear in the pixels, its value by the reference renderer, and views for it.
#pragma once

#include "render/reference/render_picture.h"
#include "render/scenes.h"

#include <cmath>
#include <random>
#include <vector>

namespace tetrec::test {

// A random field and the size of its images.
struct Scene {
  int points;
  uint32_t seed;
  int width, height;
};

// Outside at a corner, inside, and outside in front of one face. With odd sizes, blocks are cut.
inline std::vector<RenderView> ThreeViews(int width, int height) {
  return {LookAt({1.7, -1.1, -1.0}, {0.0, 0.3, 0.6}, width, height),
          LookAt({0.1, 0.4, 0.5}, {0.3, 0.6, 0.9}, width, height),
          LookAt({0.1, 0.4, 2.5}, {0.0, 0.4, 0.9}, width, height)};
}

inline std::vector<glm::dvec4> RandomPixelGradient(const Camera& camera, uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;  // floats: the device must get the same values
  std::vector<glm::dvec4> gradient(size_t(camera.width) * camera.height);
  for (glm::dvec4& g : gradient) {
    for (int i = 0; i < 4; ++i) g[i] = normal(random);
  }
  return gradient;
}

// Sum over pixels of g.(rgb, transmittance).
inline double Loss(const RadianceField& field, const RenderView& view,
                   const std::vector<glm::dvec4>& g, const IntegralOptions& integral = {}) {
  const ReferenceImage image = RenderReference(field, view, 0.0, integral);
  double loss = 0;
  for (size_t i = 0; i < g.size(); ++i) {
    loss += glm::dot(glm::dvec3(g[i]), image.color_srgb[i]) +
            g[i].a * std::exp(-image.optical_depth[i]);
  }
  return loss;
}

// (L(x + h) - L(x - h)) / 2h, with a step that the float x can represent.
inline double CentralDifference(RadianceField& field, float& value, float step,
                                const RenderView& view, const std::vector<glm::dvec4>& g,
                                const IntegralOptions& integral = {}) {
  const float before = value, above = before + step, below = before - step;
  value = above;
  const double loss_above = Loss(field, view, g, integral);
  value = below;
  const double loss_below = Loss(field, view, g, integral);
  value = before;
  return (loss_above - loss_below) / (double(above) - double(below));
}

}  // namespace tetrec::test
