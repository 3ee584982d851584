//! Percentage-closer filtering over a disc: the mean of comparisons at the taps of a pattern.
//!
//! Reeves, Salesin and Cook 1987, "Rendering antialiased shadows with depth maps", with taps spread
//! over a disc instead of a square of texels: the radius need not be whole, the cost is the number
//! of taps whatever the radius, and edges look alike from all sides. Turned by each pixel's noise,
//! few taps give fine noise instead of bands. The blur is as wide everywhere and tells nothing of
//! the light's size: see [`Pcss`](crate::Pcss). Fails like [`Pcf`](crate::Pcf) by acne that grows
//! with the radius, by light that leaks into contacts, by one width for all penumbrae, and by noise
//! where taps are few for it; and as every map does: see [`shadow_map`](crate::shadow_map).

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

/// A disc of comparisons.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "presets",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct PcfDisc {
    /// Texels, 0 to [`MAX_DISC_RADIUS`].
    pub radius: f32,
    /// Taps, 1 to [`MAX_TAPS`](crate::filtering::sample_pattern::MAX_TAPS).
    pub taps: u32,
    /// How they are spread.
    pub pattern: Pattern,
    /// Whether each pixel turns the pattern by its own noise.
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
    const SUMMARY: &'static str = "comparisons spread over a disc that each pixel turns";

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
        /// The map: its layers, and how it is compared with.
        pub lookup: ShadowMapUniforms,
        /// Texels.
        pub radius: f32,
        /// Taps: the table's first.
        pub taps: u32,
        /// Greatest turn of the pattern: one less than the number of turns, or 0.
        pub turns: u32,
    }
}

/// The receive kernel.
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

/// The disc of one span, whose first pixel is `pixel`.
#[derive(Clone, Copy)]
struct DiscOfTaps<'a> {
    kernel: &'a PcfDiscKernel,
    simd: Simd,
    comparisons: Comparisons<'a>,
    pixel: UVec2,
}

impl BatchTaps for DiscOfTaps<'_> {
    fn visibilities(&self, batch: &Batch, first: usize, out: &mut [f32]) {
        // Its own task: once compiled for all ways to project.
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
    /// Returns how the disc is laid over the map for the pixel `offset` in the span: turned by the
    /// pixel's noise.
    #[inline(always)]
    fn placement(&self, offset: usize) -> KernelPlacement {
        let u = &self.kernel.uniforms;
        let rotation = PixelRotation::at(&self.kernel.pattern, u.turns, self.pixel, offset);
        let axes = Vec4::new(u.radius, 0.0, 0.0, u.radius);
        KernelPlacement {
            axes: turned(axes, rotation.cos_sin),
            shift: Vec2::ZERO,
        }
    }
}
