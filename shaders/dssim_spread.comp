// D-SSIM, third pass: spreads the derivatives of windows along rows over their pixels.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "dssim.glsl"

layout(std430, binding = kBindWindowTerms) readonly buffer WindowTerms { float window_terms[]; };
layout(std430, binding = kBindWindowRows) writeonly buffer WindowRows { float window_rows[]; };

void main() {
  uint i = gl_GlobalInvocationID.x;
  uint plane = 3u * push.ray_count;
  if (i < plane) {
    TilePixel pixel = PixelOfRay(i % push.ray_count);
    uint channel = i - i % push.ray_count;
    vec3 sum = vec3(0.0);
    TilePixel at = pixel;
    for (int d = -kSsimReach; d <= kSsimReach; ++d) {
      at.x = pixel.x + d;
      if (at.x >= 0 && at.x < TileWidth()) {
        uint j = channel + RayOfPixel(at);
        vec3 terms =
            vec3(window_terms[j], window_terms[plane + j], window_terms[2u * plane + j]);
        sum += SsimWindowWeight(float(d)) * terms;
      }
    }
    window_rows[i] = sum.x;
    window_rows[plane + i] = sum.y;
    window_rows[2u * plane + i] = sum.z;
  }
}
