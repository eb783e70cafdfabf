// What the rasteriser passes on about a face, the same for all its pixels. In this form the view
// costs lavapipe one row of numbers per face instead of loads and a frame per pixel.
//
// corner0..2 are the vertices by ascending id, relative to `reference`, along the camera's axes.
// reference.xyz is relative to the camera, along its axes: the camera itself if it is inside the
// mesh, otherwise the centre of the mesh, so that the precision of coordinates is relative to the
// size of the mesh; reference.w is the mesh's radius around it. For the slope of a pixel's ray, add
// pixel_origin_focal.xy to the pixel's place in the batch and divide by pixel_origin_focal.zw.
#define TETREC_FACE_VIEW(direction)                         \
  layout(location = 0) flat direction vec3 corner0;         \
  layout(location = 1) flat direction vec3 corner1;         \
  layout(location = 2) flat direction vec3 corner2;         \
  layout(location = 3) flat direction uint face; /* | 1 where this order winds outwards */ \
  layout(location = 4) flat direction vec4 reference;       \
  layout(location = 5) flat direction vec4 pixel_origin_focal;
