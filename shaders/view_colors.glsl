// What the kernels of view-dependent colour share: a row's place and the basis towards it. The
// including kernel declares `push`.
#include "shared/harmonics.glsl.h"
#include "thread_index.glsl"

layout(local_size_x = kWorkgroupSize) in;
layout(binding = kBindVertices) uniform textureBuffer vertices;
layout(binding = kBindTets) uniform utextureBuffer tets;
layout(binding = kBindCenters) uniform textureBuffer centers;  // a camera centre per slot

#include "storage.glsl"

// A vertex, or the centroid of a tet.
vec3 PlaceOfRow(uint row) {
  vec3 place;
  if (kCells) {
    uvec4 ids = texelFetch(tets, int(2u * row));
    place = 0.25 * (texelFetch(vertices, int(2u * ids.x)).xyz + texelFetch(vertices, int(2u * ids.y)).xyz +
                    texelFetch(vertices, int(2u * ids.z)).xyz + texelFetch(vertices, int(2u * ids.w)).xyz);
  } else {
    place = texelFetch(vertices, int(2u * row)).xyz;
  }
  return place;
}

// The unit vector from the camera of a slot to a place; 0 if they coincide.
vec3 DirectionTo(uint slot, vec3 place) {
  vec3 ray = place - texelFetch(centers, int(slot)).xyz;
  float size = length(ray);
  return size > 0.0 ? ray / size : vec3(0.0);
}

float HarmonicAt(int k, vec3 d) { return Harmonic(k, d.x, d.y, d.z); }
