//! Which variants of the WGSL rules a map uses. Both variants of each rule stand side by side in their file; the modules of this
//! one give the chosen variant the name by which the others call it, so that what is switched off costs nothing.

use super::{
    cascades::{CASCADE_PICK, CASCADES},
    coord::{COORD, PROJECTION},
    layers::{self, LAYERS, ShadowMapUniforms},
    packing::PACKING,
    texel_compare::{DEPTH_ON_PLANE, STORED_DEPTH, TEXEL_COMPARE},
};
use umbrage_core::Module;

macro_rules! choice {
    ($name:literal, $text:literal) => {
        Module {
            name: $name,
            text: $text,
        }
    };
}

const SINGLE_MAP: Module = choice!(
    "choice: one map",
    "fn layer_at(light: vec4f, p: vec3f) -> i32 { return 0; }
fn map_layer(layer: i32) -> MapLayer { return kernel.lookup.layers[0]; }
"
);
const CUBE: Module = choice!(
    "choice: a cube of maps",
    "fn layer_at(light: vec4f, p: vec3f) -> i32 { return cube_face(light, p); }
fn map_layer(layer: i32) -> MapLayer { return kernel.lookup.layers[layer]; }
"
);
const CASCADED_MAPS: Module = choice!(
    "choice: cascades",
    "fn layer_at(light: vec4f, p: vec3f) -> i32 { return cascade_at(p); }
fn map_layer(layer: i32) -> MapLayer { return kernel.lookup.layers[layer]; }
"
);
const ONE_LAYER: Module = choice!(
    "choice: one layer answers",
    "fn receive(r: Receiver) -> f32 { return receive_from_one(r); }
"
);
const TWO_LAYERS: Module = choice!(
    "choice: the answers of two layers blend",
    "fn receive(r: Receiver) -> f32 { return receive_from_two(r); }
"
);
const FULL_LIGHT: Module = choice!(
    "choice: what no map covers is lit",
    "fn full_light(r: Receiver) -> f32 { return 1.0; }
"
);
/// The part of `receive` that all maps share.
const RECEIVE: Module = Module {
    name: "receive",
    text: include_str!("receive.wgsl"),
};
/// The part of `receive` that blends.
const RECEIVE_BLENDED: Module = Module {
    name: "receive_blended",
    text: include_str!("receive_blended.wgsl"),
};
const CONSTANT_BIAS: Module = choice!(
    "choice: a constant bias",
    "fn biased_receiver(layer: MapLayer, light: vec4f, p: vec3f, n: vec3f) -> vec4f { return vec4f(p, layer.constant); }
"
);
const SLOPE_BIAS: Module = choice!(
    "choice: a bias by the slope",
    "fn biased_receiver(layer: MapLayer, light: vec4f, p: vec3f, n: vec3f) -> vec4f {
    return receiver_with_slope_bias(layer, light, p, n);
}
"
);
const NORMAL_OFFSET: Module = choice!(
    "choice: normal offset",
    "fn biased_receiver(layer: MapLayer, light: vec4f, p: vec3f, n: vec3f) -> vec4f {
    return receiver_with_normal_offset(layer, light, p, n);
}
"
);
const ONE_DEPTH: Module = choice!(
    "choice: one depth for all taps",
    "fn receiver_gradient(layer: MapLayer, point: vec3f, n: vec3f, size: f32) -> vec2f { return vec2f(0.0, 0.0); }
fn depth_at(l: ShadowCoord, x: i32, y: i32) -> f32 { return depth_at_receiver(l, x, y); }
"
);
const RECEIVER_PLANE: Module = choice!(
    "choice: taps follow the receiver's plane",
    "fn receiver_gradient(layer: MapLayer, point: vec3f, n: vec3f, size: f32) -> vec2f {
    return plane_gradient(layer.clip_from_world, point, n, size, layer.receiver_plane);
}
fn depth_at(l: ShadowCoord, x: i32, y: i32) -> f32 { return depth_at_on_plane(l, x, y); }
"
);
const PLAIN_DEPTH: Module = choice!(
    "choice: plain depth",
    "fn stored_depth(texel: vec2i, layer: i32) -> f32 { return stored_depth_plain(texel, layer); }
"
);
const PACKED_DEPTH: Module = choice!(
    "choice: packed depth",
    "fn stored_depth(texel: vec2i, layer: i32) -> f32 { return stored_depth_packed(texel, layer); }
"
);
const LIT_BORDER: Module = choice!(
    "choice: lit border",
    "fn is_lit_beside(is_outside: bool) -> bool { return is_outside; }
"
);
const CLAMPED_BORDER: Module = choice!(
    "choice: the edge repeats",
    "fn is_lit_beside(is_outside: bool) -> bool { return false; }
"
);

const LIT_BEYOND_FAR: Module = choice!(
    "choice: lit beyond the far plane",
    "fn far_bound(layer: MapLayer) -> f32 { return 1.0; }
"
);
const COMPARED_BEYOND_FAR: Module = choice!(
    "choice: compared beyond the far plane",
    "fn far_bound(layer: MapLayer) -> f32 { return layer.far; }
"
);

impl ShadowMapUniforms {
    /// Returns the WGSL of `receive`, `shadow_coord`, `depth_at`, `stored_depth` and `tap`, as this map needs them. The technique's
    /// own WGSL gives `fn visibility(l: ShadowCoord, r: Receiver) -> f32`, for receivers that the map covers; all others are lit. The
    /// map's uniforms must be the kernel's field `lookup`.
    pub fn modules(&self) -> Vec<Module> {
        let mut modules = self.modules_without_full_light();
        modules.push(FULL_LIGHT);
        modules
    }

    /// As [`modules`](Self::modules), for techniques whose own WGSL also gives `fn full_light(r: Receiver) -> f32`, the answer for
    /// receivers that the map doesn't cover.
    pub fn modules_without_full_light(&self) -> Vec<Module> {
        let mut modules = vec![
            LAYERS,
            PROJECTION,
            COORD,
            DEPTH_ON_PLANE,
            TEXEL_COMPARE,
            RECEIVE,
        ];
        if self.arrangement == layers::CASCADES {
            modules.extend([CASCADES, CASCADE_PICK]);
        }
        if self.blends() {
            modules.push(RECEIVE_BLENDED);
        }
        modules.extend(stored_depth(self.packed != 0));
        modules.extend(self.choices());
        modules
    }

    fn choices(&self) -> [Module; 6] {
        // Layers share their bias and what is beyond their far planes.
        let layer = &self.layers[0];
        let arrangement = match self.arrangement {
            layers::CUBE => CUBE,
            layers::CASCADES => CASCADED_MAPS,
            _ => SINGLE_MAP,
        };
        let bias = match (layer.moves_receivers(), self.has_receiver_bias != 0) {
            (true, _) => NORMAL_OFFSET,
            (false, true) => SLOPE_BIAS,
            (false, false) => CONSTANT_BIAS,
        };
        [
            arrangement,
            either(self.blends(), TWO_LAYERS, ONE_LAYER),
            bias,
            either(layer.follows_plane(), RECEIVER_PLANE, ONE_DEPTH),
            either(self.clamped != 0, CLAMPED_BORDER, LIT_BORDER),
            either(layer.far == 1.0, LIT_BEYOND_FAR, COMPARED_BEYOND_FAR),
        ]
    }
}

/// Returns the WGSL of `stored_depth`, which reads the kernel's first image.
pub(crate) fn stored_depth(packed: bool) -> [Module; 3] {
    let choice = either(packed, PACKED_DEPTH, PLAIN_DEPTH);
    [PACKING, STORED_DEPTH, choice]
}

fn either(condition: bool, yes: Module, no: Module) -> Module {
    if condition { yes } else { no }
}
