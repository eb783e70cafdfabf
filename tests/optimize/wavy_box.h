// A box of waves, cameras around it, and their photos.
#pragma once

#include "field/radiance_field.h"
#include "geometry/look_at.h"
#include "mesh/delaunay.h"
#include "render/training_renderer.h"

#include <cmath>
#include <numbers>
#include <vector>

namespace tetrec {

// A box [-1, 1]^3 of side^3 vertices whose colours are waves in space; the mesh of 9^3 does not
// show in its pictures.
inline RadianceField WavyBox(double contrast, float density = 20.0f, int side = 9) {
  std::vector<glm::vec3> points;
  for (int i = 0; i < side * side * side; ++i) {
    const glm::ivec3 at(i % side, i / side % side, i / (side * side));
    points.push_back(glm::vec3(at) * (2.0f / float(side - 1)) - 1.0f);
  }
  RadianceField field;
  field.mesh = BuildDelaunay(points).mesh;
  for (const glm::vec3& p : field.mesh.positions) {
    field.density.push_back(density);
    const glm::vec3 wave(std::sin(5 * p.x + 2 * p.y), std::sin(4 * p.y - 3 * p.z),
                         std::sin(4 * p.z + 3 * p.x));
    field.color_srgb.push_back(0.5f + float(contrast) * wave);
  }
  return field;
}

inline RenderView ViewFrom(const glm::dvec3& eye) {
  return {{48, 48, 50, 50, 24, 24}, CamLookingAt(eye, glm::dvec3(0.1, 0.0, -0.1))};
}

inline std::vector<RenderView> Ring(size_t views) {
  std::vector<RenderView> ring;
  for (size_t i = 0; i < views; ++i) {
    const double turn = 2 * std::numbers::pi * double(i) / double(views);
    ring.push_back(ViewFrom({2.6 * std::cos(turn), 2.6 * std::sin(turn), 1.0}));
  }
  return ring;
}

// The picture of a view as a photo has it.
inline TargetImage PhotoOf(Renderer& renderer, const RenderView& view) {
  const RenderedImage image = renderer.Render(view, 1);
  TargetImage photo{image.width, image.height, {}};
  for (size_t i = 0; i < image.color_srgb.size(); ++i) {
    uint32_t packed = uint32_t(std::lround(255 * (1 - image.transmittance[i]))) << 24;
    for (int c = 0; c < 3; ++c) {
      packed |= uint32_t(std::lround(255 * image.color_srgb[i][c])) << (8 * c);
    }
    photo.rgba8.push_back(packed);
  }
  return photo;
}

}  // namespace tetrec
