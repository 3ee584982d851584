// Twin of yardstick.rs: a chain of loads and products that nothing can shorten.

struct YardstickUniforms {
    mask: u32,
    links: u32,
}

fn receive(r: Receiver) -> f32 {
    var x = r.pixel.x * 0x9e3779b9u + r.pixel.y * 0x85ebca6bu;
    for (var i = 0u; i < kernel.links; i++) {
        x = (x ^ table_0[(x >> 7u) & kernel.mask].x) * 0x2c1b3c6du;
        x = x ^ (x >> 15u);
    }
    return f32(x >> 24u) / 255.0;
}
