// import holes_hashed
// What the camera's pass over triangles with holes reads in addition if an alpha texture is
// mipmapped and hashed.

@group(0) @binding(4) var<storage> coverage: array<vec4u>;
