//! Variants of a map's WGSL. This module declares the constants that select them; the variants are
//! in the files of the functions. Compilers remove the unselected ones.

use super::{
    cascades::{CASCADES, LAYER_PICK},
    coord::{COORD, PROJECTION},
    layers::{LAYERS, ShadowMapUniforms},
    packing::PACKING,
    texel_compare::{DEPTH_ON_PLANE, STORED_DEPTH, TEXEL_COMPARE},
};
use umbrage_core::{Arrangement, Module, module};

/// Expands to a module that declares one constant: `constant!("IS_PACKED = true")`.
macro_rules! constant {
    ($declaration:literal) => {
        umbrage_core::Module {
            name: concat!("constant: ", $declaration),
            text: concat!("const ", $declaration, ";\n"),
        }
    };
}
pub(crate) use constant;

const SINGLE_MAP: Module = constant!("ARRANGEMENT = SINGLE_MAP");
const CUBE: Module = constant!("ARRANGEMENT = CUBE");
const CASCADED_MAPS: Module = constant!("ARRANGEMENT = CASCADED_MAPS");
const CONSTANT_BIAS: Module = constant!("BIAS = CONSTANT_BIAS");
const SLOPE_BIAS: Module = constant!("BIAS = SLOPE_BIAS");
const NORMAL_OFFSET: Module = constant!("BIAS = NORMAL_OFFSET");
const RECEIVER_PLANE: Module = constant!("TAPS_FOLLOW_PLANE = true");
const ONE_DEPTH: Module = constant!("TAPS_FOLLOW_PLANE = false");
const CLAMPED_BORDER: Module = constant!("EDGE_REPEATS = true");
const LIT_BORDER: Module = constant!("EDGE_REPEATS = false");
const CLAMPED_BEYOND_FAR: Module = constant!("BEYOND_FAR = CLAMPED_BEYOND_FAR");
const LIT_BEYOND_FAR: Module = constant!("BEYOND_FAR = LIT_BEYOND_FAR");
const COMPARED_BEYOND_FAR: Module = constant!("BEYOND_FAR = COMPARED_BEYOND_FAR");
const PACKED_DEPTH: Module = constant!("IS_PACKED = true");
const PLAIN_DEPTH: Module = constant!("IS_PACKED = false");

/// WGSL of `receive` that all maps share.
const RECEIVE: Module = module!("receive");
/// WGSL of `receive` if each receiver has one layer. The other variant is a separate file. With a
/// constant, compilers would inline the technique's lookup twice before they remove one of the
/// calls.
const RECEIVE_ONE: Module = module!("receive_one");
/// WGSL of `receive` if two layers blend.
const RECEIVE_BLENDED: Module = module!("receive_blended");
/// WGSL of `full_light` if receivers outside the map are lit.
const FULL_LIGHT: Module = module!("full_light");

impl ShadowMapUniforms {
    /// Returns the WGSL of `receive`, `shadow_coord`, `depth_at`, `stored_depth` and `tap` for this
    /// map, followed by the technique's `own`. The latter defines
    /// `fn visibility(l: ShadowCoord, r: Receiver) -> f32` for receivers that the map covers; all
    /// others are lit. The map's uniforms must be the kernel's field `lookup`.
    pub fn modules(&self, own: &[Module]) -> Vec<Module> {
        let mut modules = self.modules_without_full_light(&[FULL_LIGHT]);
        modules.extend(own);
        modules
    }

    /// Returns the WGSL like [`modules`](Self::modules), for techniques that also define
    /// `fn full_light(r: Receiver) -> f32`. This is the visibility of receivers that the map
    /// doesn't cover.
    pub fn modules_without_full_light(&self, own: &[Module]) -> Vec<Module> {
        let mut modules = self.constants().to_vec();
        modules.extend([
            LAYERS,
            PROJECTION,
            CASCADES,
            LAYER_PICK,
            COORD,
            DEPTH_ON_PLANE,
            TEXEL_COMPARE,
            RECEIVE,
            either(self.blends(), RECEIVE_BLENDED, RECEIVE_ONE),
        ]);
        modules.extend(stored_depth(self.packed != 0));
        modules.extend(own);
        modules
    }

    /// Returns the constants that select the map's variants.
    fn constants(&self) -> [Module; 5] {
        // Layers share their bias and their handling of receivers beyond the far plane.
        let layer = &self.layers[0];
        let arrangement = match self.arrangement() {
            Arrangement::Single => SINGLE_MAP,
            Arrangement::Cube => CUBE,
            Arrangement::Cascades(_) => CASCADED_MAPS,
        };
        let bias = match (layer.moves_receivers(), layer.has_receiver_bias()) {
            (true, _) => NORMAL_OFFSET,
            (false, true) => SLOPE_BIAS,
            (false, false) => CONSTANT_BIAS,
        };
        let beyond_far = match (layer.far == 1.0, layer.deepest == 1.0) {
            (true, _) => LIT_BEYOND_FAR,
            (false, true) => CLAMPED_BEYOND_FAR,
            (false, false) => COMPARED_BEYOND_FAR,
        };
        [
            arrangement,
            bias,
            either(layer.follows_plane(), RECEIVER_PLANE, ONE_DEPTH),
            either(self.clamped != 0, CLAMPED_BORDER, LIT_BORDER),
            beyond_far,
        ]
    }
}

/// Returns the WGSL of `stored_depth`, which reads the kernel's first image.
pub(crate) fn stored_depth(packed: bool) -> [Module; 3] {
    let is_packed = either(packed, PACKED_DEPTH, PLAIN_DEPTH);
    [is_packed, PACKING, STORED_DEPTH]
}

fn either(condition: bool, yes: Module, no: Module) -> Module {
    if condition { yes } else { no }
}
