// What the view of a ray shows at the ray's pixel: the ray, or the mean of the pixel's 2 x 2 rays,
// which are in one block. The including kernel declares `push`, a LossPush, ray_colors and targets.

struct ShownPixel {
  vec3 color;  // before the background and the exposure
  float transmittance;
};

ShownPixel ShownByRay(uint ray) {
  vec4 color = ray_colors[ray];
  return ShownPixel(color.rgb, exp(-color.a));
}

ShownPixel ShownAt(uint ray) {
  ShownPixel shown = ShownByRay(ray);
  if (push.samples == 2u) {
    // Neighbours differ in the lowest bits of column and row.
    ShownPixel beside = ShownByRay(ray ^ 1u), below = ShownByRay(ray ^ kBlockWidth);
    ShownPixel across = ShownByRay(ray ^ (kBlockWidth + 1u));
    shown.color = 0.25 * (shown.color + beside.color + below.color + across.color);
    shown.transmittance = 0.25 * (shown.transmittance + beside.transmittance + below.transmittance +
                                  across.transmittance);
  }
  return shown;
}

// The target pixel for ray (x, y) of a view with this size in rays and this first pixel (GpuView).
uint TargetPixel(uvec4 size_pixel, uint x, uint y) {
  return size_pixel.z + (y / push.samples) * (size_pixel.x / push.samples) + x / push.samples;
}

// A texel contains four pixels, because devices limit the number of texels.
vec4 FetchTarget(uint pixel) {
  uvec4 four = texelFetch(targets, int(pixel >> 2));
  return unpackUnorm4x8(four[pixel & 3u]);
}
