// Encoding of moments in this map's images. Separate from stored.wgsl, which the twin tests use
// without an encoding.

// Values of `ENCODING`: see stored.rs.
const FLOATS = 0u;
const VARIANCE_16 = 1u;
const POWERS_16 = 2u;
const EXPONENTIALS_16 = 3u;

fn stored_moments(moments: vec4f) -> vec4f {
    if ENCODING == VARIANCE_16 {
        return vec4f(store_variance(moments.xy), 0.0, 0.0);
    }
    if ENCODING == POWERS_16 {
        return store_powers(moments);
    }
    if ENCODING == EXPONENTIALS_16 {
        return store_exponentials(moments);
    }
    return moments;
}

fn loaded_moments(channels: vec4f) -> vec4f {
    if ENCODING == VARIANCE_16 {
        return vec4f(load_variance(channels.xy), 0.0, 0.0);
    }
    if ENCODING == POWERS_16 {
        return load_powers(channels);
    }
    if ENCODING == EXPONENTIALS_16 {
        return load_exponentials(channels);
    }
    return channels;
}
