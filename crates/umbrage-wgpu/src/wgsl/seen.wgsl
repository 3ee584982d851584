// The surface that a pixel of the camera shows. `umbrage_seen(texel)` returns it.

struct UmbrageSeen {
    receives: bool,
    position: vec3f,
    normal: vec3f,
    triangle: u32,
}
