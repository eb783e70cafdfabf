// Lists the rows to which the views of a batch have given gradients, in nearly their own order. Most
// rows have none, but most groups of neighbouring rows have one that does: the list lets the kernel
// that moves rows fill all its lanes.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/gpu_types.glsl.h"
#include "shared/glsl_subset.h"
#include "thread_index.glsl"
#ifdef TETREC_FIXED_POINT
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#endif
#define TETREC_NEVER (push.row_count == 0u)

layout(local_size_x = kWorkgroupSize) in;
layout(push_constant) uniform Push { SeenRowsPush push; };
#ifdef TETREC_FIXED_POINT
layout(std430, binding = kBindSlotGradients) readonly buffer SlotGradients { int64_t slot_gradients[]; };
#else
layout(std430, binding = kBindSlotGradients) readonly buffer SlotGradients { float slot_gradients[]; };
#endif
// The same sums as texels, which are read whole.
layout(binding = kBindSlotGradientTexels) uniform textureBuffer slot_gradient_texels;
layout(std430, binding = kBindSeenRows) buffer SeenRows { uint seen_rows[]; };

bool IsSeenBy(uint slot, uint row) {
  uint texel = slot * push.row_count + row;
#ifdef TETREC_FIXED_POINT
  uint at = 4u * texel;
  return slot_gradients[at] != 0 || slot_gradients[at + 1u] != 0 || slot_gradients[at + 2u] != 0 ||
         slot_gradients[at + 3u] != 0;
#else
  return texelFetch(slot_gradient_texels, int(texel)) != vec4(0.0);
#endif
}

// The first of the rows that need another row of workgroups asks for it.
void List(uint row) {
  uint at = atomicAdd(seen_rows[kSeenRowsCount], 1u);
  seen_rows[kSeenRowsHeader + at] = row;
  TETREC_RARELY(at % (kSeenRowsGroupsAcross * kWorkgroupSize) == 0u) {
    atomicAdd(seen_rows[kSeenRowsGroups + 1], 1u);
  }
}

void main() {
  uint row = ThreadIndex();
  if (row < push.row_count) {
    bool is_seen = false;
    uint slot = 0u;
    while (slot < push.slots) {
      is_seen = IsSeenBy(slot, row) || is_seen;
      slot += 1u;
    }
    TETREC_RARELY(is_seen) List(row);
    TETREC_RARELY(row == 0u) {
      seen_rows[kSeenRowsGroups] = kSeenRowsGroupsAcross;
      seen_rows[kSeenRowsGroups + 2] = 1u;
    }
  }
}
