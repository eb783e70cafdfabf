// Sorts the list of every ray by distance, and by face if distances are equal, so that the order
// does not depend on that of the rasteriser.
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

// Lets `moved` sink from `place` in the heap of `size` fragments that starts at `first`; the
// farthest is on top.
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

// Shell sort with the gaps of Ciura 2001; the last gap alone is an insertion sort. Faces are drawn
// front to back by chunks, so most lists are almost sorted: an insertion sort alone comes first, as
// long as it moves fragments by no more than kShortWay places on average.
const uint kGaps[10] = uint[](1u, 1750u, 701u, 301u, 132u, 57u, 23u, 10u, 4u, 1u);
const uint kShortWay = 12u;
// The insertion sort alone stops after this many rounds, far below MostLoopRounds (gpu/device.h).
const uint kMostShortRounds = 4096u;

// One round compares the moved fragment with one other: neighbouring lists, which lavapipe sorts
// together, wait for each other only at the end.
void Sort(uint first, uint count) {
  uint g = 0u, gap = 1u, i = 1u, place = 1u;
  uint rounds = 0u;
  uvec2 moved = uvec2(0u);
  bool go = count > 1u;
  if (go) moved = fragments[first + 1u];
  while (go) {
    uvec2 other = fragments[first + place - gap];
    bool moves = Before(moved, other);
    fragments[first + place] = moves ? other : moved;
    place -= moves ? gap : 0u;
    bool at_begin = moves && place < gap;
    if (at_begin) fragments[first + place] = moved;
    rounds += 1u;
    bool placed = !moves || at_begin;
    if (placed) {
      i += 1u;
      bool short_ways = g > 0u || rounds <= min(kShortWay * count, kMostShortRounds);
      if (i >= count || !short_ways) {
        // Gaps as long as the list have nothing to sort.
        go = g < 9u && !(g == 0u && short_ways);
        g += 1u;
        while (go && kGaps[min(g, 9u)] >= count) g += 1u;
        gap = kGaps[min(g, 9u)];
        i = gap;
      }
      place = i;
      if (go) moved = fragments[first + i];
    }
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
