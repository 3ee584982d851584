// import holes_hashed
// Additional binding of the camera's pass over alpha-tested triangles, if an alpha texture is
// mipmapped and hashed.

@group(0) @binding(4) var<storage> coverage: array<vec4u>;
