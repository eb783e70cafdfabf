// Integrates emission and absorption along rays through a volume, on the CPU; its images are the
// ground truth.
//
// sigma = density_at_opacity_1 * opacity; a ray gathers int sigma c e^-tau dt, tau = int sigma dt.
// c is display sRGB, as everywhere in the field and its images: what is integrated is what a field
// can represent. In each cell of the grid the trilinear interpolant is a cubic along the ray:
//   pre-shaded: the transfer function is applied at the samples, then density and colour are
//     interpolated independently, so that sigma is a cubic;
//   post-shaded: the sample is interpolated, then the transfer function is applied, so that sigma
//   is
//     a cubic between two crossings of the transfer function's knots, which are located.
// In both cases tau is a quartic, evaluated exactly, and int sigma c e^-tau uses four
// Gauss-Legendre nodes per part, where a part has an optical depth of about 1. A ray ends when its
// transmittance falls below kStopTransmittance.
#pragma once

#include "geometry/camera.h"
#include "geometry/rigid3.h"
#include "image/image.h"
#include "volume/shaded_transfer.h"
#include "volume/volume.h"

#include <glm/glm.hpp>

#include <vector>

namespace tetrec {

enum class Shading { kPre, kPost };
template <>
inline constexpr auto kWords<Shading> = std::to_array<Word<Shading>>({{Shading::kPre, "pre"},
                                                                      {Shading::kPost, "post"}});

// Colour and opacity gathered along a ray.
struct GatheredColor {
  glm::vec3 premultiplied_srgb{0.0f};  // [0, 1], times alpha
  float alpha = 0;
};

class RayIntegrator {
 public:
  static constexpr float kStopTransmittance = 1e-4f;

  // `world_from_volume` is from the volume's own coordinates (spacings and origin) and has no
  // rotation. `density_at_opacity_1` is in [1 / world unit]. Keeps a reference to the volume.
  RayIntegrator(const Volume& volume, const TransferFunction& function, double density_at_opacity_1,
                Shading shading, const Similarity3& world_from_volume);

  // `parts` subdivides each part of a ray further; 1 is accurate.
  GatheredColor Gather(const glm::dvec3& origin_in_world, const glm::dvec3& unit_direction_in_world,
                       int parts = 1) const;

  // Density [1 / world unit] and display sRGB at every sample, in its order.
  const std::vector<glm::vec4>& shaded_samples() const { return shaded_; }
  // The number of samples with a density above 0.
  size_t CountDense() const { return dense_; }
  // False if every image would be empty. A post-shaded volume may be visible without any dense
  // sample, because the values between two samples are shaded too.
  bool AnythingVisible() const;

 private:
  struct CellPassage;
  struct Gathering;

  void ShadeSamples(const TransferFunction& function);
  void FindVisibleBlocks();
  bool IsVisible(const glm::ivec3& block) const;
  template <class Visit>
  void Walk(const glm::dvec3& origin, const glm::dvec3& direction, const Visit& visit) const;
  bool GatherPreShaded(const CellPassage& passage, Gathering& gathering) const;
  bool GatherPostShaded(const CellPassage& passage, Gathering& gathering) const;

  const Volume& volume_;
  ShadedTransfer transfer_;
  float density_at_opacity_1_;
  Shading shading_;
  glm::dvec3 origin_in_world_, spacing_in_world_;
  std::vector<glm::vec4> shaded_;
  size_t dense_ = 0;
  glm::ivec3 blocks_{0};                // of kBlockCells^3 cells
  std::vector<uint8_t> visible_block_;  // x fastest
};

// Renders an RGBA image with straight alpha; each pixel is the mean of rays_per_side^2 rays on a
// regular grid.
Image RenderVolume(const RayIntegrator& rays, const Camera& camera, const Rigid3& cam_from_world,
                   int rays_per_side);

}  // namespace tetrec
