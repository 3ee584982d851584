//! Morton codes: numbers by which neighbours in space become neighbours in a list.

use glam::{DVec2, DVec3};

/// Bits of each coordinate.
pub(crate) const BITS: u32 = 21;

/// Returns the code of a point in the unit cube; the nearest one's for points outside.
pub(crate) fn code_3d(p: DVec3) -> u64 {
    every_third(step(p.x)) | every_third(step(p.y)) << 1 | every_third(step(p.z)) << 2
}

/// Returns the code of a point in the unit square; the nearest one's for points outside.
pub(crate) fn code_2d(p: DVec2) -> u64 {
    every_second(step(p.x)) | every_second(step(p.y)) << 1
}

/// Returns the coordinates of a code, 0..2^21.
pub(crate) fn place_2d(code: u64) -> [u64; 2] {
    let place = |axis: u32| {
        let bits = (0..BITS).map(|bit| (code >> (2 * bit + axis) & 1) << bit);
        bits.sum()
    };
    [place(0), place(1)]
}

fn step(fraction: f64) -> u64 {
    let steps = f64::from(1 << BITS);
    (fraction * steps).clamp(0.0, steps - 1.0) as u64
}

/// Moves bit i to bit 3i.
fn every_third(x: u64) -> u64 {
    let mut x = x & 0x1f_ffff;
    x = (x | x << 32) & 0x001f_0000_0000_ffff;
    x = (x | x << 16) & 0x001f_0000_ff00_00ff;
    x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

/// Moves bit i to bit 2i.
fn every_second(x: u64) -> u64 {
    let mut x = x & 0x1f_ffff;
    x = (x | x << 16) & 0x0000_ffff_0000_ffff;
    x = (x | x << 8) & 0x00ff_00ff_00ff_00ff;
    x = (x | x << 4) & 0x0f0f_0f0f_0f0f_0f0f;
    x = (x | x << 2) & 0x3333_3333_3333_3333;
    (x | x << 1) & 0x5555_5555_5555_5555
}
