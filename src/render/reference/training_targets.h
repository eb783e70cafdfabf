// What batches are compared with: pictures of the training views, and how these views show the
// field.
#pragma once

#include "render/reference/batch_rays.h"
#include "render/training_renderer.h"
#include "shared/exposure.glsl.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <vector>

namespace tetrec {

// One picture and one exposure per view.
struct TrainingTargets {
  std::vector<RenderView> views;
  std::vector<TargetImage> pictures;
  std::vector<ViewExposure> exposures;
};

// The exposure of a ray's view.
inline const ViewExposure& ExposureOf(const TrainingTargets& targets, const BatchRays& batch,
                                      size_t ray) {
  return targets.exposures[batch.IndexOfView(ray)];
}

// The target of a ray's pixel, premultiplied.
template <class Real>
Vec4<Real> TargetOfRay(const TrainingTargets& targets, const BatchRays& batch, size_t ray) {
  const TargetImage& picture = targets.pictures[batch.IndexOfView(ray)];
  const glm::ivec2 at = batch.PixelAt(ray);
  const uint32_t rgba8 = picture.rgba8[size_t(at.y) * size_t(picture.width) + size_t(at.x)];
  Vec4<Real> value;
  for (int c = 0; c < 4; ++c) value[c] = Real(rgba8 >> (8 * c) & 255u) / Real(255);
  return value;
}

// The colour of a ray's pixel as its view exposes it. `shown`: of ShownPixels.
template <class Real>
Vec3<Real> Exposed(const ViewExposure& exposure, const Vec4<Real>& shown) {
  Vec3<Real> exposed;
  for (int c = 0; c < 3; ++c) {
    exposed[c] = ExposedColor(shown[c], shown.a, Real(exposure.gain[c]), Real(exposure.offset[c]));
  }
  return exposed;
}

// dL/d(colour, transmittance) of a ray for dL/d(exposed colour on the background).
template <class Real>
Vec4<Real> GradientOfRay(const ViewExposure& exposure, const Vec3<Real>& by_shown,
                         const Vec3<Real>& background) {
  return {by_shown * Vec3<Real>(exposure.gain),
          glm::dot(by_shown, background - Vec3<Real>(exposure.offset))};
}

}  // namespace tetrec
