//! Depth in four 8-bit channels, as in WebGL 1. This is for devices that can neither read depth
//! images nor draw into float images.
//!
//! Depth z is written in base 256, one digit per channel: z = k0/256 + k1/256² + k2/256³ + k3/256⁴.
//! Each k is an integer from 0 to 255, stored as k/255. Multiplying by 256 and taking the fraction
//! are exact in binary floats. So a depth of 2^-8 or more loses nothing (24 bits, the precision of
//! a float), and a smaller one loses less than 2^-32. 1 becomes 1 - 2^-32, which rounds back to 1.
//!
//! Known failure: packed depth cannot be filtered, nor compared by samplers, since the digits of
//! neighbours are unrelated.

use glam::{UVec2, Vec4};
use std::sync::Arc;
use umbrage_core::{FilterKernel, Inputs, Kernel, Module, module};

/// The WGSL half.
pub const PACKING: Module = module!("packing");

/// Packs a depth 0..=1 into four channels, 0..=1.
#[inline(always)]
pub fn pack_depth(z: f32) -> Vec4 {
    let a = z * 256.0;
    let ka = a.floor().min(255.0);
    let b = (a - ka) * 256.0;
    let kb = b.floor().min(255.0);
    let c = (b - kb) * 256.0;
    let kc = c.floor().min(255.0);
    let d = (c - kc) * 256.0;
    let kd = d.floor().min(255.0);
    Vec4::new(ka / 255.0, kb / 255.0, kc / 255.0, kd / 255.0)
}

/// Unpacks a depth from channels whose error is less than half a step.
#[inline(always)]
pub fn unpack_depth(c: Vec4) -> f32 {
    let k0 = digit(c.x);
    let k1 = digit(c.y);
    let k2 = digit(c.z);
    let k3 = digit(c.w);
    let digit_size = 1.0 / 256.0;
    (k0 + (k1 + (k2 + k3 * digit_size) * digit_size) * digit_size) * digit_size
}

/// Returns the digit, 0 to 255, of a channel.
#[inline(always)]
fn digit(channel: f32) -> f32 {
    (channel * 255.0 + 0.5).floor()
}

/// Returns the filter from a depth image to one with four channels.
pub(crate) fn pack() -> Arc<dyn FilterKernel> {
    Arc::new(PackKernel)
}

/// Filter that packs a depth image.
#[derive(Clone, Copy, Debug)]
pub struct PackKernel;

impl Kernel for PackKernel {
    fn modules(&self) -> Vec<Module> {
        vec![PACKING, module!("pack")]
    }
}

impl FilterKernel for PackKernel {
    fn filter(&self, inputs: &Inputs<'_>, start: UVec2, layer: u32, out: &mut [f32]) {
        for (x, texel) in (start.x as i32..).zip(out.chunks_exact_mut(4)) {
            let depth = inputs.images[0].load(x, start.y as i32, layer);
            texel.copy_from_slice(&pack_depth(depth).to_array());
        }
    }
}

/// All twins of this module, for the tests that compare them.
#[cfg(feature = "testing")]
pub const TWINS: &[umbrage_core::Twin] = &[
    umbrage_core::twin!(PACKING, pack_depth(z: f32) -> Vec4, needs [umbrage_core::MATH]),
    umbrage_core::twin!(PACKING, unpack_depth(c: Vec4) -> f32, needs [umbrage_core::MATH]),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packing_loses_nothing_above_a_256th() {
        for i in 0..200_000_u32 {
            let z = (1.0 - i as f32 * 4.97e-6).clamp(1.0 / 256.0, 1.0);
            assert_eq!(unpack_depth(pack_depth(z)).to_bits(), z.to_bits(), "{z}");
        }
        for z in [0.0, 1e-9, 1e-5, 0.0033, 1.0 / 257.0] {
            assert!((unpack_depth(pack_depth(z)) - z).abs() < 2.4e-10, "{z}");
        }
    }

    /// An error from 8-bit storage of each channel must not matter; an error of a whole step must.
    #[test]
    fn channels_are_whole_steps() {
        let c = pack_depth(0.713_456_7);
        for v in c.to_array() {
            assert!((v * 255.0 - (v * 255.0).round()).abs() < 1e-4, "{v}");
        }
        let stored = c
            .to_array()
            .map(|v| f64::from((v * 255.0).round()) as f32 * (1.0 / 255.0));
        assert_eq!(unpack_depth(Vec4::from_array(stored)), 0.713_456_7);
        assert_ne!(
            unpack_depth(c + Vec4::new(0.0, 0.0, 1.0 / 255.0, 0.0)),
            0.713_456_7
        );
    }
}
