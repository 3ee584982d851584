//! Dithered percentage-closer filtering: four comparisons, placed by the pixel's parity.
//!
//! Bunnell and Pellacini 2004, "Shadow map antialiasing" (GPU Gems, chapter 11): taps at (-1.5, .5), (.5, .5),
//! (-1.5, -1.5) and (.5, -1.5) texels, moved by (0 or 1, 0 or 1) so that each block of 2x2 pixels covers sixteen texels.
//! Cheap, at the price of a fine pattern in the penumbra; its levels are fourths. Known failures: single pixels of acne
//! where light grazes curved or creased surfaces, as some taps are 2.5 texels away; light leaks into contacts as far;
//! and those of every map: see [`shadow_map`](crate::shadow_map).

use crate::{
    lanes::{
        batch::{BATCH, Batch, BatchTaps, Lanes, look_up_span},
        single::single_taps,
        whole::floor,
    },
    listing::ListedTechnique,
    shadow_map::{ShadowMap, layers::MapOnlyUniforms, texel_compare::DepthMap},
};
use glam::{UVec2, Vec2};
use umbrage_core::{
    Inputs, Kernel, Light, Module, ReceiveKernel, Recipe, RecipeError, ShadowTechnique, Span,
    UniformBlock, View,
};

/// Four dithered comparisons.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct PcfDithered {
    /// The map looked up.
    pub map: ShadowMap,
}

impl ShadowTechnique for PcfDithered {
    fn name(&self) -> &'static str {
        "pcf_dithered"
    }

    fn recipe(&self, view: &View<'_>) -> Result<Recipe, RecipeError> {
        self.map.recipe(view, 2.0, |lookup| {
            PcfDitheredKernel(MapOnlyUniforms { lookup })
        })
    }

    fn follows_camera(&self, light: &Light) -> bool {
        self.map.follows_camera(light)
    }
}

impl ListedTechnique for PcfDithered {
    const SUMMARY: &'static str =
        "four comparisons, placed by the pixel's parity (Bunnell, Pellacini 2004)";

    fn settings(&self) -> String {
        format!("4 taps, {}", self.map.label())
    }

    fn map(&self) -> Option<&ShadowMap> {
        Some(&self.map)
    }

    fn with_map(self, map: ShadowMap) -> Self {
        Self { map }
    }
}

/// The receive kernel.
#[derive(Clone, Copy, Debug)]
pub struct PcfDitheredKernel(
    /// Uniforms.
    pub MapOnlyUniforms,
);

impl Kernel for PcfDitheredKernel {
    fn modules(&self) -> Vec<Module> {
        self.0
            .lookup
            .modules()
            .into_iter()
            .chain([Module {
                name: "pcf_dithered",
                text: include_str!("pcf_dithered.wgsl"),
            }])
            .collect()
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

impl BatchTaps for DitheredTaps<'_> {
    #[inline(always)]
    fn visibilities(&self, batch: &Batch, first: usize, out: &mut [f32]) {
        if self.map.packed {
            self.one_by_one(batch, first, out);
            return;
        }
        let [columns, rows] = self.columns_and_rows(batch, first);
        let mut lit = [0.0; BATCH];
        let mut is_known = [true; BATCH];
        for y in &rows {
            for x in &columns {
                let taps = single_taps(&self.map, batch, x, y);
                for i in 0..BATCH {
                    lit[i] += taps.lit[i];
                    is_known[i] &= taps.is_known[i];
                }
            }
        }
        let mut is_complete = true;
        for (i, out) in out.iter_mut().enumerate() {
            *out = lit[i] * 0.25;
            is_complete &= is_known[i] | !batch.covered[i];
        }
        // Beside the map all is lit, unless its edge repeats.
        if self.map.clamped && !is_complete {
            self.one_by_one(batch, first, out);
        }
    }
}

impl DitheredTaps<'_> {
    /// Returns the two columns and the two rows of the taps of a batch of receivers, of which the first lies `first` pixels right of the span's
    /// first.
    #[inline(always)]
    fn columns_and_rows(&self, batch: &Batch, first: usize) -> [[Lanes<f32>; 2]; 2] {
        let mut shift_x = [0.0; BATCH];
        let mut shift_y = [0.0; BATCH];
        for i in 0..BATCH {
            let shift = self.shift(first + i);
            shift_x[i] = shift.x;
            shift_y[i] = shift.y;
        }
        [
            texels_around(&batch.x, &shift_x),
            texels_around(&batch.y, &shift_y),
        ]
    }

    /// Returns by how many texels a pixel moves its taps: in a block of 2x2 each by its own one of (0 or 1, 0 or 1). `offset` is its
    /// place in the span.
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
        let [columns, rows] = self.columns_and_rows(batch, first);
        batch.one_by_one(out, |l, i| {
            let mut lit = 0.0;
            for y in &rows {
                for x in &columns {
                    lit += self.map.tap(l, x[i] as i32, y[i] as i32);
                }
            }
            lit * 0.25
        });
    }
}

/// Returns the two texels along one axis at which receivers take their taps.
#[inline(always)]
fn texels_around(place: &Lanes<f32>, shift: &Lanes<f32>) -> [Lanes<f32>; 2] {
    let mut out = [[0.0; BATCH]; 2];
    for i in 0..BATCH {
        out[0][i] = floor(place[i] + (shift[i] - 1.5));
        out[1][i] = floor(place[i] + (shift[i] + 0.5));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::fixtures::{batch, map, texels};

    /// Returns the mean of the four taps, as Bunnell and Pellacini have it.
    fn expected(map: &DepthMap<'_>, batch: &Batch, i: usize, pixel: UVec2) -> f32 {
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

    /// At both kinds of edges, from odd pixels and even ones on, in batches that are full and in one that isn't.
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
                assert_eq!(out, expected(&map, &batch, i, pixel), "{turn} {i}");
                greys += usize::from(out > 0.0 && out < 1.0);
            }
        }
        assert!(greys > 400, "{greys}");
    }
}
