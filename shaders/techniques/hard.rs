//! Hard shadows: one comparison with one texel.
//!
//! A receiver is lit if its depth minus the bias is at most the stored depth. Williams 1978,
//! "Casting curved shadows on curved surfaces".
//!
//! Known failures: jagged edges as wide as a texel, acne without bias, detached shadows with too
//! much of it, penumbrae without width, and those of every map: see
//! [`shadow_map`](crate::shadow_map).

use crate::{
    lanes::{
        batch::{BATCH, Batch, BatchTaps, look_up_span},
        single::single_taps,
        whole::floor,
    },
    shadow_map::{ShadowMap, coord::ShadowCoord, layers::MapOnlyUniforms, texel_compare::DepthMap},
    techniques::map_technique::MapFilter,
};
use umbrage_core::{
    Inputs, Kernel, Module, ReceiveKernel, Recipe, RecipeError, Span, UniformBlock, View, module,
};

/// One comparison per receiver.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct Hard {}

impl MapFilter for Hard {
    const NAME: &'static str = "hard";
    const SUMMARY: &'static str = "one comparison with one texel (Williams 1978)";

    fn recipe(&self, map: &ShadowMap, view: &View<'_>) -> Result<Recipe, RecipeError> {
        map.recipe(view, 0.0, |lookup| HardKernel(MapOnlyUniforms { lookup }))
    }
}

/// Receive kernel of hard shadows.
#[derive(Clone, Copy, Debug)]
pub struct HardKernel(
    /// Map and its layers.
    pub MapOnlyUniforms,
);

impl Kernel for HardKernel {
    fn modules(&self) -> Vec<Module> {
        self.0.lookup.modules(&[module!("hard")])
    }

    fn uniforms(&self) -> Option<&dyn UniformBlock> {
        Some(&self.0)
    }
}

impl ReceiveKernel for HardKernel {
    fn receive(&self, inputs: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]) {
        let taps = OwnTexel {
            map: self.0.lookup.map(&inputs.images[0]),
        };
        look_up_span(inputs.simd, &self.0.lookup, span, out, &taps);
    }
}

/// Comparison with the receiver's own texel.
pub(crate) struct OwnTexel<'a> {
    pub(crate) map: DepthMap<'a>,
}

impl OwnTexel<'_> {
    /// Returns the visibility of a receiver that the map covers. Twin of `visibility` in hard.wgsl.
    #[inline(always)]
    fn visibility(&self, l: &ShadowCoord) -> f32 {
        let x = l.texel.x.floor() as i32;
        let y = l.texel.y.floor() as i32;
        self.map.tap(l, x, y)
    }

    #[inline(never)]
    fn one_by_one(&self, batch: &Batch, out: &mut [f32]) {
        batch.one_by_one(out, |l, _| self.visibility(l));
    }
}

impl BatchTaps for OwnTexel<'_> {
    /// Runs in vector lanes, 2.0 and 2.1 times as fast as one receiver after the other (1280x720,
    /// `street`, a map of 2048, AVX2).
    #[inline(always)]
    fn visibilities(&self, batch: &Batch, _: usize, out: &mut [f32]) {
        if self.map.packed {
            self.one_by_one(batch, out);
            return;
        }
        let [mut x, mut y] = [[0.0; BATCH]; 2];
        for i in 0..BATCH {
            x[i] = floor(batch.x[i]);
            y[i] = floor(batch.y[i]);
        }
        let taps = single_taps(&self.map, batch, &x, &y);
        let mut is_complete = true;
        for (i, out) in out.iter_mut().enumerate() {
            *out = taps.lit[i];
            is_complete &= taps.is_known[i] | !batch.covered[i];
        }
        // Receivers outside the map are lit, unless its edge repeats.
        if self.map.clamped && !is_complete {
            self.one_by_one(batch, out);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        lanes::fixtures::{batch, map, texels},
        shadow_map::packing::pack_depth,
    };

    /// Includes receivers outside the map, repeated edges, packed maps and partial batches.
    #[test]
    fn own_texels_are_as_the_plain_comparison() {
        let texels = texels();
        let packed: Vec<f32> = texels
            .iter()
            .flat_map(|&depth| pack_depth(depth).to_array())
            .collect();
        for (clamped, is_packed) in [(false, false), (true, false), (false, true), (true, true)] {
            let map = DepthMap {
                packed: is_packed,
                ..map(if is_packed { &packed } else { &texels }, clamped)
            };
            for turn in 0..40 {
                let batch = batch(turn, turn % 2 == 0);
                let mut out = [9.0; BATCH];
                let count = if turn % 3 == 0 { 13 } else { BATCH };
                OwnTexel { map }.visibilities(&batch, 0, &mut out[..count]);
                for (i, out) in out[..count].iter().enumerate() {
                    let l = batch.lookup(i);
                    let [x, y] = [l.texel.x.floor() as i32, l.texel.y.floor() as i32];
                    let expected = if l.covered { map.tap(&l, x, y) } else { 1.0 };
                    assert_eq!(*out, expected, "{clamped} {is_packed} {x} {y}");
                }
            }
        }
    }
}
