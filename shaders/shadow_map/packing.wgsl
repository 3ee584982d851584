// Twin of packing.rs: depth in base 256.

fn pack_depth(z: f32) -> vec4f {
    let a = z * 256.0;
    let ka = min(floor(a), 255.0);
    let b = (a - ka) * 256.0;
    let kb = min(floor(b), 255.0);
    let c = (b - kb) * 256.0;
    let kc = min(floor(c), 255.0);
    let d = (c - kc) * 256.0;
    let kd = min(floor(d), 255.0);
    return vec4f(ka / 255.0, kb / 255.0, kc / 255.0, kd / 255.0);
}

fn unpack_depth(c: vec4f) -> f32 {
    let k = floor(c * 255.0 + vec4f(0.5));
    let digit_size = 1.0 / 256.0;
    return (k.x + (k.y + (k.z + k.w * digit_size) * digit_size) * digit_size) * digit_size;
}
