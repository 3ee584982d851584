// import holes_hashed
@group(UMBRAGE_GROUP) @binding(3) var<storage> coverage: array<vec4u>;
