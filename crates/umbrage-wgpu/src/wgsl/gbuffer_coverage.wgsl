// What the camera's pass over triangles with holes reads besides where an alpha texture is mipmapped and hashed: after gbuffer_holes.wgsl.

@group(0) @binding(4) var<storage> coverage: array<vec4u>;
