// D-SSIM over tiles of rays: which ray lies where, and the window's way over the pixels.
//
// Four kernels, a thread a ray, or a ray of one channel: the window's means along rows
// (dssim_rows), along columns, and SSIM's derivatives by them (dssim_windows); these spread back over
// the pixels of the windows along rows (dssim_spread), along columns, into the rays' gradients
// (dssim_gradients). Only windows inside their tile count: each is then a window of the whole picture.
//
// Planes of buffers hold a value for each channel and ray, channel by channel.
#include "shared/gpu_types.glsl.h"
#include "shared/ssim.glsl.h"

layout(local_size_x = kWorkgroupSize) in;
layout(push_constant) uniform Push { DssimPush push; };

// A pixel of a tile; x, y from the tile's first.
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

// Whether the row (or column) of the window around `at` lies in [0, size).
bool IsInside(int at, int size) { return at >= kSsimReach && at < size - kSsimReach; }
