// The rays of a batch, in blocks of 4 x 2 that name their views. The including kernel declares `push`
// with its RayPush `rays`. Every ray is moved inside its cell of the grid by its own jitter; with
// TETREC_ONE_JITTER all rays of the batch are moved alike, as rasterisation requires.
#include "shared/random.glsl.h"
#include "views.glsl"

const uint kNoTet = 0xFFFFFFFFu, kNoVertex = 0xFFFFFFFFu;

struct Ray {
  vec3 origin, direction, u, v;
  bool valid;       // inside the image
  uint start_tet;   // tet that contains the camera, or kNoTet
  uint slot;        // of its view in the batch
};

vec2 Jitter(uint index) {
#ifdef TETREC_ONE_JITTER
  uint random = Hash(push.rays.jitter_seed);
#else
  uint random = Hash(push.rays.jitter_seed ^ Hash(index));
#endif
  return push.rays.jitter_px * vec2(UnitFloat(random) - 0.5, UnitFloat(Hash(random)) - 0.5);
}

// Through pixel (x, y) of a view.
Ray MakeRayThrough(GpuView view, uint x, uint y, vec2 jitter) {
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
  ray.start_tet = view.size_pixel_tet.w;
  ray.slot = 0u;
  return ray;
}

Ray MakeRay(uint index) {
  GpuBlock block = FetchBlock(index / kBlockRays);
  uint lane = index % kBlockRays;
  Ray ray = MakeRayThrough(FetchView(block.view), block.x + lane % kBlockWidth,
                           block.y + lane / kBlockWidth, Jitter(index));
  ray.slot = block.slot;
  return ray;
}

// Axes u and v are across the ray, d is along it. Equal positions give equal bits.
vec3 InRayFrame(Ray ray, vec3 position) {
  precise vec3 r = position - ray.origin;
  precise vec3 p = vec3(dot(r, ray.u), dot(r, ray.v), dot(r, ray.direction));
  return p;
}

// Twice the area of (0, from, to) across the ray; exactly its negative for (to, from).
float EdgeFunction(vec3 from, vec3 to) {
  precise float left = from.x * to.y;
  precise float right = from.y * to.x;
  precise float e = left - right;
  return e;
}
