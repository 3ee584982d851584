//! Counting lit texels of a square, a row of lanes at a time. Counts are small integers in floats, which add exactly in
//! any order: so the lanes agree with the shader's loop to the bit.

use crate::shadow_map::{coord::ShadowCoord, texel_compare::DepthMap};

/// Returns how many taps of the square of `SIDE` texels a side whose least texel is (x, y) are lit; `None` unless it lies wholly
/// within the map and its rows may be read `LANES` wide. Lanes beyond `SIDE` are not counted.
#[inline(always)]
pub fn square<const SIDE: usize, const LANES: usize>(
    map: &DepthMap<'_>,
    l: &ShadowCoord,
    x: i32,
    y: i32,
) -> Option<f32> {
    let texels = map.layer(l.layer)?;
    let size = map.size;
    let side = SIDE as i32;
    if x < 0 || y < 0 || x + side > size || y + side > size {
        return None;
    }
    let stride = size as usize;
    let first = y as usize * stride + x as usize;
    let window = texels.get(first..first + (SIDE - 1) * stride + LANES)?;
    let mut lit = [0_u32; LANES];
    if l.gradient == glam::Vec2::ZERO {
        for row in 0..SIDE {
            let stored: &[f32; LANES] = window[row * stride..][..LANES].first_chunk()?;
            for (lit, stored) in lit.iter_mut().zip(stored) {
                *lit += u32::from(l.depth <= *stored);
            }
        }
    } else {
        for row in 0..SIDE {
            let stored: &[f32; LANES] = window[row * stride..][..LANES].first_chunk()?;
            // `depth_on_plane` of the row's texels: its term for y is the same for all of them.
            let down = l.gradient.y * ((y + row as i32) as f32 + 0.5 - l.texel.y);
            for (lane, lit) in lit.iter_mut().enumerate() {
                let right = l.gradient.x * ((x + lane as i32) as f32 + 0.5 - l.texel.x);
                let depth = (l.depth + right + down).min(l.deepest);
                *lit += u32::from(depth <= stored[lane]);
            }
        }
    }
    Some(lit[..SIDE].iter().sum::<u32>() as f32)
}

/// Counts the lit taps of the square with `side` texels a side whose least texel is (x, y): [`square`] of any side, anywhere.
#[inline]
pub fn one_by_one(map: &DepthMap<'_>, l: &ShadowCoord, x: i32, y: i32, side: i32) -> f32 {
    let mut lit = 0.0;
    for dy in 0..side {
        for dx in 0..side {
            lit += map.tap(l, x + dx, y + dy);
        }
    }
    lit
}
