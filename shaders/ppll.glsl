// Per-pixel lists of the faces that rays pass.
//
// Which faces a ray passes is decided exactly, by the signs of edge functions in a frame that has
// the ray as an axis: the sign of a difference of products of floats is computed without rounding,
// and a zero is decided as if every vertex were moved by its own infinitesimal amount (Edelsbrunner
// and Muecke 1990, "Simulation of simplicity"). So a ray passes 0 or 2 faces of every tet, through
// edges and vertices too, and its faces form chains from hull to hull. Rounding affects only their
// distances, which are continuous.
#define TETREC_ONE_JITTER
#define TETREC_NEVER (push.rays.ray_count == 0u)

#include "shared/gpu_types.glsl.h"

layout(push_constant) uniform Push { PpllPush push; };

#include "rays.glsl"
#include "integral.glsl"

layout(binding = kBindTets) uniform utextureBuffer tets;
layout(binding = kBindVertices) uniform textureBuffer vertices;

#include "cells.glsl"

// The ray through pixel `at`, which counts from the batch's first pixel.
uint RayOfPixel(uvec2 at) {
  uint block = at.y / kBlockHeight * push.block_columns + at.x / kBlockWidth;
  return block * kBlockRays + at.y % kBlockHeight * kBlockWidth + at.x % kBlockWidth;
}

// A ray whose origin is moved to where the mesh's ball may start, so that the precision of
// coordinates in its frame is relative to the size of the mesh; camera_z is where the camera then
// is, 0 or less.
struct ListRay {
  Ray ray;
  float camera_z;
};

// `at` counts from the batch's first pixel. No index here differs from ray to ray, so
// lavapipe loads once for eight of them.
ListRay MakeListRay(uvec2 at) {
  ListRay result;
  GpuBlock first = FetchBlock(0u);
  result.ray = MakeRayThrough(FetchView(push.view), first.x + at.x, first.y + at.y, Jitter(0u));
  float begin =
      dot(push.mesh_ball.xyz - result.ray.origin, result.ray.direction) - push.mesh_ball.w;
  begin = result.ray.start_tet == kNoTet ? max(begin, 0.0) : 0.0;
  result.ray.origin += begin * result.ray.direction;
  result.camera_z = -begin;
  return result;
}

vec3 EdgeFunctions(vec3 a, vec3 b, vec3 c) {
  return vec3(EdgeFunction(b, c), EdgeFunction(c, a), EdgeFunction(a, b));
}

// Barycentric weights of the point where a ray passes a triangle, for the vertices opposite the
// edges.
vec3 WeightsOf(vec3 edge_functions) {
  vec3 w = abs(edge_functions);
  float sum = w.x + w.y + w.z;
  return sum > 0.0 ? w * (1.0 / sum) : vec3(1.0 / 3.0);
}

vec3 HitWeights(vec3 a, vec3 b, vec3 c) { return WeightsOf(EdgeFunctions(a, b, c)); }

// Vertices of face i, ascending by their place in the tet; wound outwards if i is even.
uvec3 FaceVertices(uvec4 ids, uint i) {
  return i == 0u ? ids.yzw : i == 1u ? ids.xzw : i == 2u ? ids.xyw : ids.xyz;
}
