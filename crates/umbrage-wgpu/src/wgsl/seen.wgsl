// The visible surface of a pixel. `umbrage_seen(texel)` returns it.

struct UmbrageSeen {
    receives: bool,
    position: vec3f,
    normal: vec3f,
    triangle: u32,
}
