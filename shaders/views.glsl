// Views and blocks of rays, read as texels: lavapipe reads storage buffers word by word, in a loop
// over lanes.
layout(binding = kBindViews) uniform utextureBuffer views;    // rows of GpuView
layout(binding = kBindBlocks) uniform utextureBuffer blocks;  // one GpuBlock per texel

GpuView FetchView(uint index) {
  int row = int(index * kViewRows);
  return GpuView(uintBitsToFloat(texelFetch(views, row)), uintBitsToFloat(texelFetch(views, row + 1)),
                 uintBitsToFloat(texelFetch(views, row + 2)),
                 uintBitsToFloat(texelFetch(views, row + 3)), texelFetch(views, row + 4));
}

GpuBlock FetchBlock(uint index) {
  uvec4 block = texelFetch(blocks, int(index));
  return GpuBlock(block.x, block.y, block.z, block.w);
}
