// Twin of stored.rs: moments as channels of 16 bits, and back.

fn store_variance(moments: vec2f) -> vec2f {
    return vec2f(moments.x * 0.5 + 0.5, moments.y);
}

fn load_variance(channels: vec2f) -> vec2f {
    let depth = channels.x * 2.0 - 1.0;
    return vec2f(min(max(depth, -1.0), 1.0), channels.y);
}

fn store_powers(b: vec4f) -> vec4f {
    let first = min(max(1.5 * b.x - 2.0 * b.z, -0.5), 0.5);
    let third = min(max(0.8660254 * b.x - 0.38490018 * b.z, -0.5), 0.5);
    return vec4f(first + 0.5, 4.0 * b.y - 4.0 * b.w, third + 0.5, 0.5 * b.y + 0.5 * b.w);
}

fn load_powers(channels: vec4f) -> vec4f {
    let first = channels.x - 0.5;
    let third = channels.z - 0.5;
    let moments = vec4f(
        1.7320508 * third - 0.33333334 * first,
        0.125 * channels.y + channels.w,
        1.2990381 * third - 0.75 * first,
        channels.w - 0.125 * channels.y,
    );
    return min(max(moments, vec4f(-1.0)), vec4f(1.0));
}

fn store_exponential(value: f32) -> f32 {
    let bits = bitcast<u32>(value);
    let rounded = (bits + 0x4000u) >> 15u;
    return f32(rounded) * (1.0 / 65535.0);
}

fn load_exponential(channel: f32) -> f32 {
    let rounded = min(u32(max(channel, 0.0) * 65535.0 + 0.5), 0xfeffu);
    return bitcast<f32>(rounded << 15u);
}

fn store_exponentials(moments: vec4f) -> vec4f {
    return vec4f(
        store_exponential(moments.x),
        store_exponential(moments.y),
        store_exponential(moments.z),
        store_exponential(moments.w),
    );
}

fn load_exponentials(channels: vec4f) -> vec4f {
    return vec4f(
        load_exponential(channels.x),
        load_exponential(channels.y),
        load_exponential(channels.z),
        load_exponential(channels.w),
    );
}
