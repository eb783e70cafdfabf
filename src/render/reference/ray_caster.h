// Rays of batches and of pictures through a field, and what is counted of them.
#pragma once

#include "render/reference/seen_fields.h"

#include <glm/glm.hpp>

#include <atomic>
#include <optional>
#include <vector>

namespace tetrec {

// `boxes` are always those of the field's mesh.
template <class Real>
class RayCaster {
 public:
  explicit RayCaster(const RendererOptions& options)
      : integral_(options.integral),
        stop_depth_(StopDepthOf<Real>(options.stop_transmittance)),
        counts_steps_(options.count_steps) {}

  Real stop_depth() const { return stop_depth_; }
  RenderCounts counts() const {
    RenderCounts counts;
    counts.rays = rays_;
    counts.hit_rays = hit_rays_;
    counts.steps = steps_;
    return counts;
  }

  // Colour before the background and optical depth of every ray; 0 outside the picture.
  std::vector<Vec4<Real>> March(const RadianceField& field, const TetBoxes& boxes,
                                const BatchRays& batch) {
    std::vector<Vec4<Real>> colors(batch.count(), Vec4<Real>(Real(0)));
    const SeenFields seen = FieldsSeenBy(batch, field);
    ParallelFor(batch.count(), kRaysPerTask, [&](size_t first, size_t last) {
      for (size_t i = first; i < last; ++i) {
        if (!batch.InPicture(i)) continue;
        const RayResult<Real> ray = Cast(FieldFor(seen, batch, i), boxes, RayOf<Real>(batch, i));
        colors[i] = Vec4<Real>(ray.color_srgb, ray.optical_depth);
      }
    });
    rays_ += batch.count();
    return colors;
  }

  // As Renderer::Render. `seen`: the field with the colours that the view sees.
  RenderedImage Render(const RadianceField& seen, const TetBoxes& boxes, const RenderView& view,
                       int samples) {
    const int width = view.camera.width, height = view.camera.height;
    const size_t pixels = size_t(width) * size_t(height);
    RenderedImage image{width, height, std::vector<glm::vec3>(pixels), std::vector<float>(pixels)};
    ParallelFor(pixels, kRaysPerTask, [&](size_t first, size_t last) {
      for (size_t i = first; i < last; ++i) {
        const glm::dvec2 corner(double(i % size_t(width)), double(i / size_t(width)));
        Vec3<Real> color(Real(0));
        Real transmittance(0);
        for (int sample = 0; sample < samples * samples; ++sample) {
          const glm::dvec2 inside =
              (glm::dvec2(sample % samples, sample / samples) + 0.5) / double(samples);
          const RayResult<Real> ray = Cast(seen, boxes, RayThrough<Real>(view, corner + inside));
          color += ray.color_srgb;
          transmittance += std::exp(-ray.optical_depth);
        }
        const Real share = Real(1) / Real(samples * samples);
        image.color_srgb[i] = glm::vec3(share * color);
        image.transmittance[i] = float(share * transmittance);
      }
    });
    rays_ += pixels * size_t(samples * samples);
    return image;
  }

  // As Renderer::RenderDepth.
  DepthMap RenderDepth(const RadianceField& field, const TetBoxes& boxes, const RenderView& view,
                       double optical_depth) {
    const int width = view.camera.width, height = view.camera.height;
    DepthMap map = MakeDepthMap(width, height);
    ParallelFor(map.depth.size(), kRaysPerTask, [&](size_t first, size_t last) {
      for (size_t i = first; i < last; ++i) {
        const glm::ivec2 at(int(i % size_t(width)), int(i / size_t(width)));
        const WorldRay<Real> ray = RayThrough<Real>(view, glm::dvec2(at) + 0.5);
        const auto segments = CutMesh<Real>(field, boxes, ray, Real(optical_depth));
        const std::optional<Real> reach = ReachOf<Real>(field, segments, Real(optical_depth));
        if (reach) map.depth[i] = float(DepthOfDistance(view.camera, at, double(*reach)));
      }
    });
    rays_ += map.depth.size();
    return map;
  }

  // AddGradients of the rays of a picture, one per pixel. `pixel_gradient`: dL/d(rgb,
  // transmittance).
  void Backpropagate(const RadianceField& seen, const TetBoxes& boxes, const RenderView& view,
                     std::span<const glm::vec4> pixel_gradient, bool with_positions,
                     ReferenceGradient& sum) {
    const size_t width = size_t(view.camera.width);
    AddGradients(
        seen, boxes, pixel_gradient.size(),
        [&](size_t i) {
          return RayThrough<Real>(view, {double(i % width) + 0.5, double(i / width) + 0.5});
        },
        [&](size_t i) { return Vec4<Real>(pixel_gradient[i]); }, with_positions, sum);
    rays_ += pixel_gradient.size();
  }

  // As the free function. These rays are not counted: March has counted them.
  template <class RayOf, class GradientOf>
  void AddGradients(const RadianceField& seen, const TetBoxes& boxes, size_t count,
                    const RayOf& ray, const GradientOf& gradient, bool with_positions,
                    ReferenceGradient& sum) const {
    tetrec::AddGradients<Real>(seen, boxes, count, ray, gradient, stop_depth_, integral_,
                               with_positions, sum);
  }

 private:
  RayResult<Real> Cast(const RadianceField& seen, const TetBoxes& boxes,
                       const WorldRay<Real>& ray) {
    const auto result =
        IntegrateRay<Real>(seen, CutMesh<Real>(seen, boxes, ray, stop_depth_), integral_);
    if (counts_steps_ && result.tets > 0) {
      ++hit_rays_;
      steps_ += result.tets;
    }
    return result;
  }

  IntegralOptions integral_;
  Real stop_depth_;
  bool counts_steps_;
  uint64_t rays_ = 0;
  std::atomic<uint64_t> hit_rays_ = 0, steps_ = 0;  // counted by many threads
};

}  // namespace tetrec
