// What the rasteriser passes on of a face, the same for all its pixels: here the view costs lavapipe one
// row of numbers a face instead of loads and a frame a pixel.
//
// corner0..2: the vertices by ascending id, from `reference`, along the camera's axes. reference.xyz is
// seen from the camera along its axes: the camera itself where it is in the mesh, else the middle of the
// mesh, so that coordinates are as precise as the mesh is small; reference.w is the mesh's radius about
// it. pixel_origin_focal: what to add to a pixel's place in the batch, and what to divide by, for the
// slope of its ray.
#define TETREC_FACE_VIEW(direction)                         \
  layout(location = 0) flat direction vec3 corner0;         \
  layout(location = 1) flat direction vec3 corner1;         \
  layout(location = 2) flat direction vec3 corner2;         \
  layout(location = 3) flat direction uint face; /* | 1 where this order winds outwards */ \
  layout(location = 4) flat direction vec4 reference;       \
  layout(location = 5) flat direction vec4 pixel_origin_focal;
