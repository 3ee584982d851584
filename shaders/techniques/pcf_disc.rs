//! Percentage-closer filtering over a disc: the mean of comparisons at the taps of a pattern.
//!
//! Reeves, Salesin and Cook 1987, "Rendering antialiased shadows with depth maps", with taps on a
//! disc instead of a square of texels. The radius need not be an integer. The cost is the number of
//! taps for any radius, and edges look the same in all directions. Each pixel's noise rotates the
//! taps, so that few taps give fine noise instead of bands. The blur has a constant width that is
//! independent of the light's size; compare [`Pcss`](crate::Pcss).
//!
//! Known failures: like [`Pcf`](crate::Pcf), acne that grows with the radius, light leaks into
//! contacts, and one width for all penumbrae. Noise appears if taps are few for the radius. The
//! failures of every map also apply: see [`shadow_map`](crate::shadow_map).

use crate::{
    filtering::{
        pattern_taps::{Comparisons, KernelPlacement, PATTERN_TAPS, PixelRotation, ReceiverLanes},
        sample_pattern::{PATTERN, Pattern, PatternShape, PatternTable, TURNS, turned},
    },
    lanes::batch::{Batch, BatchTaps, look_up_span},
    shadow_map::{ShadowMap, layers::ShadowMapUniforms},
    techniques::map_technique::MapFilter,
};
use glam::{UVec2, Vec2, Vec4};
use std::sync::Arc;
use umbrage_core::{
    Inputs, Invalid, Kernel, Module, ReceiveKernel, Recipe, RecipeError, Simd, SimdTask, Span,
    UniformBlock, View, module, uniforms,
};

/// Greatest radius accepted, texels.
pub const MAX_DISC_RADIUS: f32 = 64.0;

/// Disc of comparisons.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct PcfDisc {
    /// Radius, texels, 0 to [`MAX_DISC_RADIUS`].
    pub radius: f32,
    /// Number of taps, 1 to [`MAX_TAPS`](crate::filtering::sample_pattern::MAX_TAPS).
    pub taps: u32,
    /// Distribution of the taps.
    pub pattern: Pattern,
    /// True if each pixel rotates the pattern by its own noise.
    pub rotate: bool,
}

impl Default for PcfDisc {
    fn default() -> Self {
        Self {
            radius: 3.0,
            taps: 16,
            pattern: Pattern::Vogel,
            rotate: true,
        }
    }
}

impl MapFilter for PcfDisc {
    const NAME: &'static str = "pcf_disc";
    const SUMMARY: &'static str = "comparisons over a disc, rotated per pixel";

    fn recipe(&self, map: &ShadowMap, view: &View<'_>) -> Result<Recipe, RecipeError> {
        if !(0.0..=MAX_DISC_RADIUS).contains(&self.radius) {
            let why = format!("is {} texels", self.radius);
            return Err(Invalid::new(
                "pcf disc radius",
                why,
                format!("use 0 to {MAX_DISC_RADIUS}"),
            )
            .into());
        }
        let pattern = PatternTable::new(
            self.pattern,
            PatternShape::Disc,
            &[("pcf disc taps", self.taps)],
        )?;
        let table = pattern.table.clone();
        let turns = if self.rotate { TURNS - 1 } else { 0 };
        let kernel = |lookup| {
            let uniforms = PcfDiscUniforms {
                lookup,
                radius: self.radius,
                taps: self.taps,
                turns,
            };
            PcfDiscKernel { uniforms, pattern }
        };
        let mut recipe = map.recipe(view, self.radius, kernel)?;
        recipe.tables.push(table);
        recipe.receive.tables.push(0);
        Ok(recipe)
    }

    fn label(&self) -> String {
        let still = if self.rotate { "" } else { " still" };
        format!(
            "radius {}, {} taps,{still} {}",
            self.radius,
            self.taps,
            self.pattern.name()
        )
    }
}

uniforms! {
    /// Uniforms of [`PcfDiscKernel`].
    pub struct PcfDiscUniforms {
        /// Layers of the map and how they are compared.
        pub lookup: ShadowMapUniforms,
        /// Radius, texels.
        pub radius: f32,
        /// Number of taps; they are first in the table.
        pub taps: u32,
        /// Greatest turn of the pattern: one less than the number of turns, or 0.
        pub turns: u32,
    }
}

/// Receive kernel of disc PCF.
#[derive(Clone, Debug)]
pub struct PcfDiscKernel {
    /// Uniforms.
    pub uniforms: PcfDiscUniforms,
    pattern: Arc<PatternTable>,
}

impl Kernel for PcfDiscKernel {
    fn modules(&self) -> Vec<Module> {
        let own = [PATTERN, PATTERN_TAPS, module!("pcf_disc")];
        self.uniforms.lookup.modules(&own)
    }

    fn uniforms(&self) -> Option<&dyn UniformBlock> {
        Some(&self.uniforms)
    }
}

impl ReceiveKernel for PcfDiscKernel {
    fn receive(&self, inputs: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]) {
        let lookup = &self.uniforms.lookup;
        let taps = DiscOfTaps {
            kernel: self,
            simd: inputs.simd,
            comparisons: Comparisons {
                map: lookup.map(&inputs.images[0]),
                shape: self.pattern.shape,
                follows_plane: lookup.layers[0].follows_plane(),
            },
            pixel: span.first,
        };
        look_up_span(inputs.simd, lookup, span, out, &taps);
    }
}

/// Disc of a span whose first pixel is `pixel`.
#[derive(Clone, Copy)]
struct DiscOfTaps<'a> {
    kernel: &'a PcfDiscKernel,
    simd: Simd,
    comparisons: Comparisons<'a>,
    pixel: UVec2,
}

impl BatchTaps for DiscOfTaps<'_> {
    fn visibilities(&self, batch: &Batch, first: usize, out: &mut [f32]) {
        // A separate task, which is compiled once for all kinds of projection.
        self.simd.run_task(DiscBatch {
            disc: *self,
            batch,
            first,
            out,
        });
    }
}

struct DiscBatch<'a> {
    disc: DiscOfTaps<'a>,
    batch: &'a Batch,
    first: usize,
    out: &'a mut [f32],
}

impl SimdTask for DiscBatch<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self {
            disc,
            batch,
            first,
            out,
        } = self;
        let comparisons = &disc.comparisons;
        let size = comparisons.map.size;
        let mut receivers = ReceiverLanes::none();
        for batch_index in 0..out.len() {
            let l = batch.lookup(batch_index);
            if l.covered {
                receivers.push(&l, batch_index, size, disc.placement(first + batch_index));
            }
        }
        // Receivers that the map does not cover are lit.
        out.fill(1.0);
        let set = &disc.kernel.pattern.sets[0];
        let lit = comparisons.count_lit(&receivers, set);
        for i in 0..receivers.count {
            out[receivers.batch_index[i]] = lit[i] as f32 / disc.kernel.uniforms.taps as f32;
        }
    }
}

impl DiscOfTaps<'_> {
    /// Returns the placement of the disc on the map for the pixel `offset` in the span, rotated by
    /// the pixel's noise.
    #[inline(always)]
    fn placement(&self, offset: usize) -> KernelPlacement {
        let u = &self.kernel.uniforms;
        let rotation =
            PixelRotation::rotation_at(&self.kernel.pattern, u.turns, self.pixel, offset);
        let axes = Vec4::new(u.radius, 0.0, 0.0, u.radius);
        KernelPlacement {
            axes: turned(axes, rotation.cos_sin),
            shift: Vec2::ZERO,
        }
    }
}
