// import holes_hashed
// Additional binding of alpha-tested casts, if an alpha texture is mipmapped and hashed.

@group(1) @binding(4) var<storage> coverage: array<vec4u>;
