// The renderer that judges the others: whole images and their gradients in double.
#include "render/reference/render_picture.h"

#include "core/error.h"
#include "render/reference/batch.h"
#include "render/seen_colors.h"

#include <fmt/format.h>

namespace tetrec {
namespace {

WorldRay<double> PixelRay(const RenderView& view, size_t pixel) {
  const size_t width = size_t(view.camera.width);
  return RayThrough<double>(view, {double(pixel % width) + 0.5, double(pixel / width) + 0.5});
}

RadianceField FieldSeenBy(const RadianceField& field, const RenderView& view) {
  return FieldSeenFrom(field, view.cam_from_world.Inverse().translation);
}

size_t PixelsOf(const RenderView& view) {
  return size_t(view.camera.width) * size_t(view.camera.height);
}

}  // namespace

ReferenceImage RenderReference(const RadianceField& field, const RenderView& view,
                               double stop_transmittance, const IntegralOptions& integral) {
  const TetBoxes boxes = MakeTetBoxes(field.mesh);
  const double stop_depth = StopDepthOf<double>(stop_transmittance);
  const RadianceField seen = FieldSeenBy(field, view);
  const size_t pixels = PixelsOf(view);
  ReferenceImage image{view.camera.width, view.camera.height, std::vector<glm::dvec3>(pixels),
                       std::vector<double>(pixels), std::vector<double>(pixels)};
  ParallelFor(pixels, kRaysPerTask, [&](size_t first, size_t last) {
    for (size_t pixel = first; pixel < last; ++pixel) {
      const auto segments = CutMesh<double>(seen, boxes, PixelRay(view, pixel), stop_depth);
      const RayResult<double> ray = IntegrateRay<double>(seen, segments, integral);
      image.color_srgb[pixel] = ray.color_srgb;
      image.optical_depth[pixel] = ray.optical_depth;
      image.length[pixel] = ray.length;
    }
  });
  return image;
}

ReferenceGradient BackpropagateReference(const RadianceField& field, const RenderView& view,
                                         std::span<const glm::dvec4> pixel_gradient,
                                         double stop_transmittance,
                                         const IntegralOptions& integral) {
  const size_t pixels = PixelsOf(view);
  TETREC_CHECK(pixel_gradient.size() == pixels, fmt::format("{} gradients", pixel_gradient.size()));
  ReferenceGradient sum(field);
  AddGradients<double>(
      FieldSeenBy(field, view), MakeTetBoxes(field.mesh), pixels,
      [&](size_t i) { return PixelRay(view, i); }, [&](size_t i) { return pixel_gradient[i]; },
      StopDepthOf<double>(stop_transmittance), integral, true, sum);
  return sum;
}

}  // namespace tetrec
