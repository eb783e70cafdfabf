// The rays of a batch: 4 x 2 blocks of pixels of the views that they name. The including kernel
// declares `push` with jitter_seed and jitter_px. Every ray is moved inside its pixel by its own
// jitter; with TETREC_ONE_JITTER all rays of the batch are moved alike, as rasterisation needs.
#include "shared/random.glsl.h"

layout(std430, binding = kBindViews) readonly buffer Views { GpuView views[]; };
layout(std430, binding = kBindBlocks) readonly buffer Blocks { GpuBlock blocks[]; };

const uint kNoTet = 0xFFFFFFFFu, kNoVertex = 0xFFFFFFFFu;

struct Ray {
  vec3 origin, direction, u, v;
  bool valid;       // inside the picture
  uint start_tet;   // tet that holds the camera, or kNoTet
  uint pixel;       // index into the targets
};

vec2 Jitter(uint index) {
#ifdef TETREC_ONE_JITTER
  uint random = Hash(push.jitter_seed);
#else
  uint random = Hash(push.jitter_seed ^ Hash(index));
#endif
  return push.jitter_px * vec2(UnitFloat(random) - 0.5, UnitFloat(Hash(random)) - 0.5);
}

Ray MakeRay(uint index) {
  GpuBlock block = blocks[index / kBlockRays];
  GpuView view = views[block.view];
  uint lane = index % kBlockRays;
  uint x = block.x + lane % kBlockWidth, y = block.y + lane / kBlockWidth;
  vec2 jitter = Jitter(index);
  float image_x = (float(x) + 0.5 + jitter.x - view.forward_in_world_cx.w) / view.right_in_world_fx.w;
  float image_y = (float(y) + 0.5 + jitter.y - view.center_in_world_cy.w) / view.down_in_world_fy.w;
  Ray ray;
  ray.origin = view.center_in_world_cy.xyz;
  ray.direction = normalize(image_x * view.right_in_world_fx.xyz +
                            image_y * view.down_in_world_fy.xyz + view.forward_in_world_cx.xyz);
  vec3 d = ray.direction;
  // Duff et al. 2017, "Building an orthonormal basis, revisited".
  float s = d.z >= 0.0 ? 1.0 : -1.0;
  float h = -1.0 / (s + d.z);
  float k = d.x * d.y * h;
  ray.u = vec3(1.0 + s * d.x * d.x * h, s * k, -s * d.x);
  ray.v = vec3(k, s + d.y * d.y * h, -d.y);
  ray.valid = x < view.size_pixel_tet.x && y < view.size_pixel_tet.y;
  ray.pixel = view.size_pixel_tet.z + y * view.size_pixel_tet.x + x;
  ray.start_tet = view.size_pixel_tet.w;
  return ray;
}
