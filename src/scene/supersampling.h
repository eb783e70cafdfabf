// Images from rays of any kind: each pixel is the mean of several rays.
#pragma once

#include "geometry/camera.h"
#include "geometry/rigid3.h"
#include "image/image.h"

#include <glm/glm.hpp>

#include <cmath>

namespace tetrec {

// Renders RGBA with straight alpha, or RGB if every ray is opaque. `sample_at`(origin_in_world,
// unit_direction_in_world) returns what one ray sees as a struct with `premultiplied_srgb` and
// `alpha`; each pixel is the mean of rays_per_side^2 rays on a regular grid.
template <class SampleAt>
Image RenderSupersampled(const Camera& camera, const Rigid3& cam_from_world, int rays_per_side,
                         bool has_alpha, const SampleAt& sample_at) {
  using Sample = decltype(sample_at(glm::dvec3(), glm::dvec3()));
  using Real = decltype(Sample::alpha);
  const Rigid3 world_from_cam = cam_from_world.Inverse();
  const int side = rays_per_side;
  Image image = MakeImage(camera.width, camera.height, has_alpha ? 4 : 3);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      Sample sum;
      for (int i = 0; i < side * side; ++i) {
        const glm::dvec2 offset((i % side + 0.5) / side, (i / side + 0.5) / side);
        const glm::dvec3 ray_in_cam = camera.CamFromImage(glm::dvec2(x, y) + offset);
        const Sample sample = sample_at(world_from_cam.translation,
                                        glm::normalize(world_from_cam.rotation * ray_in_cam));
        sum.premultiplied_srgb += sample.premultiplied_srgb;
        sum.alpha += sample.alpha;
      }
      uint8_t* pixel = image.At(x, y);
      if (has_alpha) pixel[3] = uint8_t(std::lround(255 * sum.alpha / Real(side * side)));
      if (has_alpha && pixel[3] == 0) continue;
      for (int c = 0; c < 3; ++c) {
        const Real straight = sum.premultiplied_srgb[c] / sum.alpha;
        pixel[c] = uint8_t(std::lround(255 * glm::clamp(straight, Real(0), Real(1))));
      }
    }
  }
  return image;
}

}  // namespace tetrec
