// D-SSIM, second pass: each window's SSIM, summed per workgroup, and its derivatives with respect
// to the window's means of x, x^2 and x y; 0 if the window leaves its tile.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "dssim.glsl"

layout(std430, binding = kBindWindowRows) readonly buffer WindowRows { float window_rows[]; };
layout(std430, binding = kBindWindowTerms) writeonly buffer WindowTerms { float window_terms[]; };
layout(std430, binding = kBindPartialSsims) writeonly buffer PartialSsims { float partial_ssims[]; };

shared float sums[kWorkgroupSize];

void main() {
  uint i = gl_GlobalInvocationID.x;
  uint lane = gl_LocalInvocationID.x;
  uint plane = 3u * push.ray_count;
  SsimAdjoint ssim = SsimAdjoint(0.0, 0.0, 0.0, 0.0);
  if (i < plane) {
    TilePixel pixel = PixelOfRay(i % push.ray_count);
    uint channel = i - i % push.ray_count;
    if (IsInside(pixel.x, TileWidth()) && IsInside(pixel.y, TileHeight())) {
      WindowMeans mean = WindowMeans(0.0, 0.0, 0.0, 0.0, 0.0);
      TilePixel at = pixel;
      for (int d = -kSsimReach; d <= kSsimReach; ++d) {
        at.y = pixel.y + d;
        uint j = channel + RayOfPixel(at);
        float weight = SsimWindowWeight(float(d));
        mean.x += weight * window_rows[j];
        mean.y += weight * window_rows[plane + j];
        mean.xx += weight * window_rows[2u * plane + j];
        mean.yy += weight * window_rows[3u * plane + j];
        mean.xy += weight * window_rows[4u * plane + j];
      }
      ssim = SsimWithDerivatives(mean);
    }
    window_terms[i] = ssim.by_x;
    window_terms[plane + i] = ssim.by_xx;
    window_terms[2u * plane + i] = ssim.by_xy;
  }
  sums[lane] = ssim.value;
  barrier();
  uint stride = kWorkgroupSize / 2;
  while (stride > 0u) {
    if (lane < stride) sums[lane] += sums[lane + stride];
    barrier();
    stride /= 2u;
  }
  if (lane == 0u) partial_ssims[gl_WorkGroupID.x] = sums[0];
}
