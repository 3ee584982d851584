//! Morton codes: numbers by which neighbours in space become neighbours in a list.

use glam::{DVec2, DVec3};

/// Steps along each axis: coordinates are in 0..=STEPS.
pub(crate) const STEPS: f64 = ((1_u32 << 21) - 1) as f64;

/// Returns the interleaved bits of the coordinates, each rounded down to 21 bits.
pub(crate) fn code_3d(p: DVec3) -> u64 {
    every_third(p.x as u64) | every_third(p.y as u64) << 1 | every_third(p.z as u64) << 2
}

/// Returns the interleaved bits of the coordinates, each rounded down to 21 bits.
pub(crate) fn code_2d(p: DVec2) -> u64 {
    every_second(p.x as u64) | every_second(p.y as u64) << 1
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
