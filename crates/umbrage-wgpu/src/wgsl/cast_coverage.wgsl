// import holes_hashed
// What casts of triangles with holes read in addition if an alpha texture is mipmapped and hashed.

@group(1) @binding(4) var<storage> coverage: array<vec4u>;
