// What casts of triangles with holes read besides where an alpha texture is mipmapped and hashed: after cast_holes.wgsl.

@group(1) @binding(4) var<storage> coverage: array<vec4u>;
