// Triangle i covers everything to the right of the viewport's i leftmost sixteenths.
#version 460

void main() {
  int triangle = gl_VertexIndex / 3, corner = gl_VertexIndex % 3;
  float left = -1.0 + float(triangle) / 8.0;
  gl_Position = vec4(corner == 2 ? left + 64.0 : left, corner == 1 ? 64.0 : -1.0, 0.5, 1.0);
}
