//! Smooth noise from integer hashes, equal on every platform.

use umbrage_core::glam::{IVec3, Vec3};

/// Returns a well-mixed word from three (the finaliser of MurmurHash3, Appleby 2011, over a
/// weighted sum).
pub(crate) fn hash(v: IVec3) -> u32 {
    let [x, y, z] = v.to_array().map(|c| c as u32);
    let mut h =
        x.wrapping_mul(0x9e37_79b1) ^ y.wrapping_mul(0x85eb_ca77) ^ z.wrapping_mul(0xc2b2_ae3d);
    h = (h ^ (h >> 16)).wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 13)).wrapping_mul(0xc2b2_ae35);
    h ^ (h >> 16)
}

/// Returns a number from 0 to 1 for three integers.
pub(crate) fn uniform(v: IVec3) -> f32 {
    (hash(v) >> 8) as f32 / 16_777_215.0
}

/// Value noise, 0 to 1: numbers at the corners of unit cells, blended with Perlin's quintic (2002,
/// "Improving Noise").
fn smooth(p: Vec3) -> f32 {
    let cell = p.floor();
    let t = p - cell;
    let t = t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let cell = cell.as_ivec3();
    // Interpolate along x, then y, then z.
    let edge = |y, z| {
        let left = uniform(cell + IVec3::new(0, y, z));
        let right = uniform(cell + IVec3::new(1, y, z));
        mix(left, right, t.x)
    };
    let back = mix(edge(0, 0), edge(1, 0), t.y);
    let front = mix(edge(0, 1), edge(1, 1), t.y);
    mix(back, front, t.z)
}

fn mix(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

/// Returns the sum of octaves of noise, about -1 to 1. Each octave has twice the frequency and half
/// the height of the previous one.
pub(crate) fn fractal(p: Vec3, octaves: u32) -> f32 {
    let octaves = (0..octaves).map(|i| {
        let frequency = (1_u32 << i) as f32;
        (2.0 * smooth(p * frequency) - 1.0) / frequency
    });
    0.5 * octaves.sum::<f32>()
}
