// Sorts the list of every ray by distance; of equal ones by face, so that the order does not depend on
// that of the rasteriser.
#version 460
#extension GL_GOOGLE_include_directive : require

#include "ppll.glsl"

layout(local_size_x = kWorkgroupSize) in;

layout(std430, binding = kBindLists) readonly buffer Lists { uvec2 lists[]; };
layout(std430, binding = kBindFragments) buffer Fragments { uvec2 fragments[]; };

bool Before(uvec2 a, uvec2 b) {
  float z_a = uintBitsToFloat(a.x), z_b = uintBitsToFloat(b.x);
  return z_a < z_b || (z_a == z_b && a.y < b.y);
}

#ifdef TETREC_HEAP

// Lets `moved` sink from `place` in the heap of `size` fragments from `first` on; the farthest is on
// top.
void Sink(uint first, uint place, uint size, uvec2 moved) {
  bool go = 2u * place + 1u < size;
  while (go) {
    uint child = 2u * place + 1u;
    uvec2 larger = fragments[first + child];
    if (child + 1u < size) {
      uvec2 right = fragments[first + child + 1u];
      if (Before(larger, right)) {
        larger = right;
        child += 1u;
      }
    }
    go = Before(moved, larger);
    if (go) {
      fragments[first + place] = larger;
      place = child;
      go = 2u * place + 1u < size;
    }
  }
  fragments[first + place] = moved;
}

void Sort(uint first, uint count) {
  uint i = count / 2u;
  while (i > 0u) {
    i -= 1u;
    Sink(first, i, count, fragments[first + i]);
  }
  uint size = count;
  while (size > 1u) {
    size -= 1u;
    uvec2 moved = fragments[first + size];
    fragments[first + size] = fragments[first];
    Sink(first, 0u, size, moved);
  }
}

#else

// Shell sort with the gaps of Ciura 2001; the last gap alone is an insertion sort.
const uint kGaps[9] = uint[](1750u, 701u, 301u, 132u, 57u, 23u, 10u, 4u, 1u);

void Sort(uint first, uint count) {
  uint g = 0u;
  while (g < 9u) {
    uint gap = kGaps[g];
    uint i = gap;
    while (i < count) {
      uvec2 moved = fragments[first + i];
      uint place = i;
      bool go = true;
      while (go) {
        uvec2 other = fragments[first + place - gap];
        go = Before(moved, other);
        if (go) {
          fragments[first + place] = other;
          place -= gap;
          go = place >= gap;
        }
      }
      fragments[first + place] = moved;
      i += 1u;
    }
    g += 1u;
  }
}

#endif

void main() {
  uint i = gl_GlobalInvocationID.x;
  bool exists = i < push.tile_pixels;
  uint pixel = exists ? i : 0u;
  uvec2 list = lists[RayOfPixel(uvec2(push.tile_x + pixel % push.tile_width,
                                      push.tile_y + pixel / push.tile_width))];
  bool takes = exists && list.y > 1u && list.y >= push.shortest && list.y <= push.longest;
  Sort(list.x, takes ? list.y : 0u);
}
