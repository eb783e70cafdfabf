// Compares every ray, or the mean of its pixel's rays, with the target pixel: writes dL/dcolour and
// dL/dtransmittance, and for each workgroup a partial sum of the loss and of the squared error.
//
// The loss is a mean over rays and the three channels, to whose sum opacity adds its part
// (shared/loss.glsl.h). What is compared is the ray as its view exposes it
// (shared/exposure.glsl.h).
// TETREC_PICTURES also writes the compared values, for the kernels of D-SSIM.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/gpu_types.glsl.h"
#include "shared/loss.glsl.h"
#include "shared/ssim.glsl.h"
#include "exposure.glsl"
#include "views.glsl"

layout(local_size_x = kWorkgroupSize) in;
layout(std430, binding = kBindRayColors) readonly buffer RayColors { vec4 ray_colors[]; };
layout(std430, binding = kBindRayGradients) writeonly buffer RayGradients { vec4 ray_gradients[]; };
layout(std430, binding = kBindPartialLosses) writeonly buffer PartialLosses { vec2 partial_losses[]; };
layout(binding = kBindTargets) uniform utextureBuffer targets;
#ifdef TETREC_PICTURES
layout(std430, binding = kBindPictures) writeonly buffer Pictures { vec2 pictures[]; };
#endif
layout(push_constant) uniform Push { LossPush push; };

#include "shown_pixels.glsl"

shared vec2 sums[kWorkgroupSize];

void main() {
  uint index = gl_GlobalInvocationID.x;
  uint lane = gl_LocalInvocationID.x;
  vec2 sum = vec2(0.0);
  if (index < push.ray_count) {
    GpuBlock block = FetchBlock(index / kBlockRays);
    uvec4 size_pixel = FetchView(block.view).size_pixel_tet;
    uint x = block.x + index % kBlockWidth, y = block.y + (index % kBlockRays) / kBlockWidth;
    vec4 gradient = vec4(0.0);
    if (x < size_pixel.x && y < size_pixel.y) {
      vec4 target = FetchTarget(TargetPixel(size_pixel, x, y));
      ShownPixel pixel = ShownAt(index);
      float transmittance = pixel.transmittance;
      Exposure exposure = FetchExposure(block.view);
      vec3 exposed = Exposed(pixel.color, transmittance, exposure);
#ifdef TETREC_PICTURES
      vec3 shown = exposed + transmittance * push.background.rgb;
      vec3 wanted = target.rgb + (1.0 - target.a) * push.background.rgb;
      if (!IsJudged(target.r, target.a)) shown = wanted = vec3(kNotJudged);
      pictures[index] = vec2(shown.r, wanted.r);
      pictures[push.ray_count + index] = vec2(shown.g, wanted.g);
      pictures[2u * push.ray_count + index] = vec2(shown.b, wanted.b);
#endif
      vec3 by_shown;
      uint c = 0u;
      while (c < 3u) {
        float residual = ResidualOf(exposed[c], transmittance, target[c], target.a, push.background[c]);
        by_shown[c] = push.gradient_scale * LossSlope(int(push.loss), residual);
        sum += vec2(LossOf(int(push.loss), residual), residual * residual);
        c += 1u;
      }
      if (push.writes_residuals != 0u) {
        gradient = vec4(by_shown, 0.0);
      } else {
        float excess = TransmittanceResidual(transmittance, target.r, target.a);
        gradient = GradientOfRay(by_shown, exposure, push.background.rgb);
        gradient.w += push.gradient_scale * push.alpha_weight * LossSlope(int(push.loss), excess);
        sum.x += push.alpha_weight * LossOf(int(push.loss), excess);
      }
    }
    ray_gradients[index] = gradient;
  }
  sums[lane] = sum;
  barrier();
  uint stride = kWorkgroupSize / 2;
  while (stride > 0u) {
    if (lane < stride) sums[lane] += sums[lane + stride];
    barrier();
    stride /= 2u;
  }
  if (lane == 0u) partial_losses[gl_WorkGroupID.x] = sums[0];
}
