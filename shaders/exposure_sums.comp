// Per block of rays, the sums from which the gain and offset of its view are fitted: with x the
// field's colour, w its opacity and y the colour wanted (shared/exposure.glsl.h), per channel
// (sum x w, sum x x, sum y w, sum y x), and once sum w w. There is one thread per block, so the
// sums do not depend on any order of threads.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/exposure.glsl.h"
#include "shared/gpu_types.glsl.h"
#include "shared/loss.glsl.h"
#include "views.glsl"

layout(local_size_x = kWorkgroupSize) in;
layout(std430, binding = kBindRayColors) readonly buffer RayColors { vec4 ray_colors[]; };
layout(std430, binding = kBindExposureSums) writeonly buffer ExposureSums { vec4 exposure_sums[]; };
layout(binding = kBindTargets) uniform utextureBuffer targets;
layout(push_constant) uniform Push { LossPush push; };

#include "shown_pixels.glsl"

void main() {
  uint index = gl_GlobalInvocationID.x;
  if (index < push.ray_count / kBlockRays) {
    GpuBlock block = FetchBlock(index);
    uvec4 size_pixel = FetchView(block.view).size_pixel_tet;
    vec4 of_channel[3] = vec4[3](vec4(0.0), vec4(0.0), vec4(0.0));
    float squared_opacity = 0.0;
    uint ray = 0u;
    while (ray < kBlockRays) {
      uint x = block.x + ray % kBlockWidth, y = block.y + ray / kBlockWidth;
      bool is_inside = x < size_pixel.x && y < size_pixel.y;
      bool is_first = x % push.samples == 0u && y % push.samples == 0u;  // of its pixel
      vec4 target = FetchTarget(is_inside ? TargetPixel(size_pixel, x, y) : size_pixel.z);
      if (is_inside && is_first && IsJudged(target.r, target.a)) {
        ShownPixel pixel = ShownAt(index * kBlockRays + ray);
        vec3 color = pixel.color;
        float transmittance = pixel.transmittance, opacity = 1.0 - transmittance;
        for (int c = 0; c < 3; ++c) {
          float wanted = WantedColor(transmittance, target[c], target.a, push.background[c]);
          of_channel[c] += vec4(color[c] * opacity, color[c] * color[c], wanted * opacity,
                                wanted * color[c]);
        }
        squared_opacity += opacity * opacity;
      }
      ray += 1u;
    }
    for (int c = 0; c < 3; ++c) exposure_sums[4u * index + uint(c)] = of_channel[c];
    exposure_sums[4u * index + 3u] = vec4(squared_opacity, 0.0, 0.0, 0.0);
  }
}
