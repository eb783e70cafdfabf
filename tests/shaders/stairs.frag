// Counts the fragments of every pixel of an image that is push.width pixels wide.
#version 460

layout(push_constant) uniform Push { uint width; uint step; } push;
layout(std430, binding = 0) readonly buffer Steps { uint steps[]; };
layout(std430, binding = 1) buffer Counts { uint counts[]; };

void main() {
  uvec2 at = uvec2(gl_FragCoord.xy);
  atomicAdd(counts[at.y * push.width + at.x], push.step * steps[0]);
}
