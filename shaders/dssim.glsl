// D-SSIM over tiles of rays: the mapping between rays and pixels, shared by four kernels.
//
// dssim_rows computes each window's means along rows; dssim_windows completes them along columns
// and differentiates SSIM with respect to them; dssim_spread spreads these derivatives back over
// the windows' pixels along rows, and dssim_gradients along columns, into the rays' gradients.
// There is one thread per ray, or per ray and channel. Only windows inside their tile count, so
// that each of them is also a window of the whole image.
//
// A plane of a buffer contains one value per channel and ray, channel by channel.
#include "shared/gpu_types.glsl.h"
#include "shared/ssim.glsl.h"

layout(local_size_x = kWorkgroupSize) in;
layout(push_constant) uniform Push { DssimPush push; };

// A pixel of a tile; x and y count from the tile's first pixel.
struct TilePixel {
  uint tile;
  int x, y;
};

TilePixel PixelOfRay(uint ray) {
  uint block = ray / kBlockRays;
  uint row = block / push.tile_columns;
  TilePixel pixel;
  pixel.tile = row / push.tile_rows;
  pixel.x = int(block % push.tile_columns * kBlockWidth + ray % kBlockWidth);
  pixel.y = int(row % push.tile_rows * kBlockHeight + ray % kBlockRays / kBlockWidth);
  return pixel;
}

uint RayOfPixel(TilePixel pixel) {
  uint x = uint(pixel.x), y = uint(pixel.y);
  uint block =
      (pixel.tile * push.tile_rows + y / kBlockHeight) * push.tile_columns + x / kBlockWidth;
  return block * kBlockRays + y % kBlockHeight * kBlockWidth + x % kBlockWidth;
}

int TileWidth() { return int(push.tile_columns * kBlockWidth); }
int TileHeight() { return int(push.tile_rows * kBlockHeight); }

// True if the row (or column) of the window around `at` is within [0, size).
bool IsInside(int at, int size) { return at >= kSsimReach && at < size - kSsimReach; }
