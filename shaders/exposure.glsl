// The exposures of the training views, two texels each: gain, offset (shared/exposure.glsl.h).
#include "shared/exposure.glsl.h"

layout(binding = kBindExposures) uniform textureBuffer exposures;

struct Exposure {
  vec3 gain, offset;
};

Exposure FetchExposure(uint view) {
  return Exposure(texelFetch(exposures, int(2u * view)).rgb,
                  texelFetch(exposures, int(2u * view + 1u)).rgb);
}

vec3 Exposed(vec3 color, float transmittance, Exposure exposure) {
  vec3 exposed;
  uint c = 0u;
  while (c < 3u) {
    exposed[c] = ExposedColor(color[c], transmittance, exposure.gain[c], exposure.offset[c]);
    c += 1u;
  }
  return exposed;
}

// dL/d(color, transmittance) of a ray for dL/dshown, over `background`.
vec4 GradientOfRay(vec3 by_shown, Exposure exposure, vec3 background) {
  return vec4(by_shown * exposure.gain, dot(by_shown, background - exposure.offset));
}
