//! Dithered percentage-closer filtering: four comparisons, positioned by the pixel's parity.
//!
//! Bunnell and Pellacini 2004, "Shadow map antialiasing" (GPU Gems, chapter 11). Taps are at (-1.5,
//! .5), (.5, .5), (-1.5, -1.5) and (.5, -1.5) texels, moved by (0 or 1, 0 or 1) so that each block
//! of 2x2 pixels covers sixteen texels. It is cheap, but penumbrae have a fine pattern with levels
//! of quarters.
//!
//! Known failures: single pixels of acne at grazing light on curved or creased surfaces, as some
//! taps are 2.5 texels away. Light leaks into contacts as far. The failures of every map also
//! apply: see [`shadow_map`](crate::shadow_map).

use crate::{
    lanes::{
        batch::{BATCH, Batch, BatchTaps, Lanes, look_up_span},
        single::single_taps,
        whole::floor,
    },
    shadow_map::{ShadowMap, coord::ShadowCoord, layers::MapOnlyUniforms, texel_compare::DepthMap},
    techniques::map_technique::MapFilter,
};
use glam::{UVec2, Vec2};
use umbrage_core::{
    Inputs, Kernel, Module, ReceiveKernel, Recipe, RecipeError, Span, UniformBlock, View, module,
};

/// Four dithered comparisons.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct PcfDithered {}

impl MapFilter for PcfDithered {
    const NAME: &'static str = "pcf_dithered";
    const SUMMARY: &'static str =
        "four comparisons, positioned by the pixel's parity (Bunnell, Pellacini 2004)";

    fn recipe(&self, map: &ShadowMap, view: &View<'_>) -> Result<Recipe, RecipeError> {
        map.recipe(view, 2.0, |lookup| {
            PcfDitheredKernel(MapOnlyUniforms { lookup })
        })
    }

    fn label(&self) -> String {
        "4 taps".to_owned()
    }
}

/// Receive kernel of dithered PCF.
#[derive(Clone, Copy, Debug)]
pub struct PcfDitheredKernel(
    /// Map and its layers.
    pub MapOnlyUniforms,
);

impl Kernel for PcfDitheredKernel {
    fn modules(&self) -> Vec<Module> {
        self.0.lookup.modules(&[module!("pcf_dithered")])
    }

    fn uniforms(&self) -> Option<&dyn UniformBlock> {
        Some(&self.0)
    }
}

impl ReceiveKernel for PcfDitheredKernel {
    fn receive(&self, inputs: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]) {
        let taps = DitheredTaps {
            map: self.0.lookup.map(&inputs.images[0]),
            first: span.first,
        };
        look_up_span(inputs.simd, &self.0.lookup, span, out, &taps);
    }
}

struct DitheredTaps<'a> {
    map: DepthMap<'a>,
    first: UVec2,
}

impl DitheredTaps<'_> {
    /// Returns the visibility of a receiver that the map covers, at the pixel `offset` in the span.
    /// Twin of `visibility` in pcf_dithered.wgsl.
    #[inline(always)]
    fn visibility(&self, l: &ShadowCoord, offset: usize) -> f32 {
        let shift = self.shift(offset);
        let mut lit = 0.0;
        for down in TAPS {
            for right in TAPS {
                let x = (l.texel.x + (shift.x + right)).floor() as i32;
                let y = (l.texel.y + (shift.y + down)).floor() as i32;
                lit += self.map.tap(l, x, y);
            }
        }
        lit * 0.25
    }

    /// Returns the tap offset of a pixel, texels. Each pixel of a 2x2 block has a different one of
    /// (0 or 1, 0 or 1). `offset` is its index in the span.
    #[inline(always)]
    fn shift(&self, offset: usize) -> Vec2 {
        let pixel_x = self.first.x.wrapping_add(offset as u32);
        let pixel_y = self.first.y;
        let right = (pixel_x & 1) as i32;
        let down = ((pixel_x ^ pixel_y) & 1) as i32;
        Vec2::new(right as f32, down as f32)
    }

    #[inline(never)]
    fn one_by_one(&self, batch: &Batch, first: usize, out: &mut [f32]) {
        batch.one_by_one(out, |l, i| self.visibility(l, first + i));
    }
}

/// Tap positions along each axis before the shift, texels.
const TAPS: [f32; 2] = [-1.5, 0.5];

impl BatchTaps for DitheredTaps<'_> {
    /// Runs in vector lanes, 2.5 and 2.9 times as fast as one receiver after the other (1280x720,
    /// `street`, a map of 2048, AVX2).
    #[inline(always)]
    fn visibilities(&self, batch: &Batch, first: usize, out: &mut [f32]) {
        if self.map.packed {
            self.one_by_one(batch, first, out);
            return;
        }
        // Shift the taps of each pixel.
        let [mut shift_x, mut shift_y] = [[0.0; BATCH]; 2];
        for i in 0..BATCH {
            let shift = self.shift(first + i);
            shift_x[i] = shift.x;
            shift_y[i] = shift.y;
        }
        // Count the lit taps.
        let mut lit = [0.0; BATCH];
        let mut is_known = [true; BATCH];
        for down in TAPS {
            let y = texels_at(&batch.y, &shift_y, down);
            for right in TAPS {
                let x = texels_at(&batch.x, &shift_x, right);
                let taps = single_taps(&self.map, batch, &x, &y);
                for i in 0..BATCH {
                    lit[i] += taps.lit[i];
                    is_known[i] &= taps.is_known[i];
                }
            }
        }
        // Convert counts to visibilities.
        let mut is_complete = true;
        for (i, out) in out.iter_mut().enumerate() {
            *out = lit[i] * 0.25;
            is_complete &= is_known[i] | !batch.covered[i];
        }
        // Receivers outside the map are lit, unless its edge repeats.
        if self.map.clamped && !is_complete {
            self.one_by_one(batch, first, out);
        }
    }
}

/// Returns the texels along one axis at which receivers take a tap.
#[inline(always)]
fn texels_at(place: &Lanes<f32>, shift: &Lanes<f32>, tap: f32) -> Lanes<f32> {
    let mut out = [0.0; BATCH];
    for i in 0..BATCH {
        out[i] = floor(place[i] + (shift[i] + tap));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::fixtures::{batch, map, texels};

    /// Returns the mean of the four taps of Bunnell and Pellacini.
    fn expected_visibility(map: &DepthMap<'_>, batch: &Batch, i: usize, pixel: UVec2) -> f32 {
        let l = batch.lookup(i);
        if !l.covered {
            return 1.0;
        }
        let shift_x = (pixel.x & 1) as f32;
        let shift_y = ((pixel.x ^ pixel.y) & 1) as f32;
        let mut lit = 0.0;
        for down in [-1.5, 0.5] {
            for right in [-1.5, 0.5] {
                let x = (l.texel.x + (shift_x + right)).floor() as i32;
                let y = (l.texel.y + (shift_y + down)).floor() as i32;
                lit += map.tap(&l, x, y);
            }
        }
        lit * 0.25
    }

    /// Includes both kinds of edges, odd and even first pixels, and full and partial batches.
    #[test]
    fn batches_are_as_single_receivers() {
        let texels = texels();
        let mut greys = 0;
        for turn in 0..40 {
            let map = map(&texels, turn % 2 == 0);
            let batch = batch(turn, turn % 3 == 0);
            let span_first = UVec2::new(turn as u32 / 4, turn as u32 / 8);
            let first = if turn % 5 == 0 { BATCH } else { 0 };
            let count = if turn % 7 == 0 { 13 } else { BATCH };
            let taps = DitheredTaps {
                map,
                first: span_first,
            };
            let mut out = [9.0; BATCH];
            taps.visibilities(&batch, first, &mut out[..count]);
            for (i, &out) in out[..count].iter().enumerate() {
                let pixel = span_first + UVec2::new((first + i) as u32, 0);
                assert_eq!(
                    out,
                    expected_visibility(&map, &batch, i, pixel),
                    "{turn} {i}"
                );
                greys += usize::from(out > 0.0 && out < 1.0);
            }
        }
        assert!(greys > 400, "{greys}");
    }
}
