// D-SSIM, first pass: each window's means of x, y, x^2, y^2 and x y along rows.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "dssim.glsl"

layout(std430, binding = kBindPictures) readonly buffer Pictures { vec2 pictures[]; };
layout(std430, binding = kBindWindowRows) writeonly buffer WindowRows { float window_rows[]; };

void main() {
  uint i = gl_GlobalInvocationID.x;
  uint plane = 3u * push.ray_count;
  if (i < plane) {
    TilePixel pixel = PixelOfRay(i % push.ray_count);
    uint channel = i - i % push.ray_count;
    if (IsInside(pixel.x, TileWidth())) {
      vec2 mean = vec2(0.0);
      vec3 mean_of_products = vec3(0.0);
      TilePixel at = pixel;
      for (int d = -kSsimReach; d <= kSsimReach; ++d) {
        at.x = pixel.x + d;
        vec2 xy = pictures[channel + RayOfPixel(at)];
        vec2 weighted = SsimWindowWeight(float(d)) * xy;
        mean += weighted;
        mean_of_products += vec3(weighted * xy, weighted.x * xy.y);
      }
      window_rows[i] = mean.x;
      window_rows[plane + i] = mean.y;
      window_rows[2u * plane + i] = mean_of_products.x;
      window_rows[3u * plane + i] = mean_of_products.y;
      window_rows[4u * plane + i] = mean_of_products.z;
    }
  }
}
