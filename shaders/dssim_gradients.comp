// D-SSIM, last pass: spreads the derivatives of windows along columns, and adds dL/dcolour and
// dL/dtransmittance to the rays' gradients:
//   dL/dx of a pixel = scale sum_windows w (by_x + 2 x by_xx + y by_xy),
// with x the pixel as its view exposes it.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "dssim.glsl"
#include "exposure.glsl"
#include "views.glsl"

layout(std430, binding = kBindPictures) readonly buffer Pictures { vec2 pictures[]; };
layout(std430, binding = kBindWindowRows) readonly buffer WindowRows { float window_rows[]; };
layout(std430, binding = kBindRayGradients) buffer RayGradients { vec4 ray_gradients[]; };

void main() {
  uint ray = gl_GlobalInvocationID.x;
  uint plane = 3u * push.ray_count;
  if (ray < push.ray_count) {
    TilePixel pixel = PixelOfRay(ray);
    vec3 gradient = vec3(0.0);
    for (int channel = 0; channel < 3; ++channel) {
      uint first = uint(channel) * push.ray_count;
      vec3 sum = vec3(0.0);
      TilePixel at = pixel;
      for (int d = -kSsimReach; d <= kSsimReach; ++d) {
        at.y = pixel.y + d;
        if (at.y >= 0 && at.y < TileHeight()) {
          uint j = first + RayOfPixel(at);
          vec3 terms = vec3(window_rows[j], window_rows[plane + j], window_rows[2u * plane + j]);
          sum += SsimWindowWeight(float(d)) * terms;
        }
      }
      vec2 xy = pictures[first + ray];
      if (xy.y >= 0.0) {
        gradient[channel] = push.gradient_scale * (sum.x + 2.0 * xy.x * sum.y + xy.y * sum.z);
      }
    }
    Exposure exposure = FetchExposure(FetchBlock(ray / kBlockRays).view);
    ray_gradients[ray] += GradientOfRay(gradient, exposure, push.background.rgb);
  }
}
