//! Layers of the still casters. When a caster moves, the layer is copied and the moving casters are
//! drawn on top, without redrawing the others. Depth tests keep the nearest in any order, so the
//! result is bit-equal to drawing everything.
//!
//! A copy also has a cost: on small scenes, Godot's engine lost more by such copies than it gained
//! (pull request 77683). A layer is therefore split only where drawing the still casters costs more
//! than the copy. Costs are measured if the device has timestamps (`prices.rs`).

use crate::{
    light_set::{
        casters::Casters,
        culling::ShownSlots,
        ids::LightKey,
        options::StillLayers,
        prices::Prices,
        state::{HeldLight, LightCast, StillLayer},
    },
    resources::{
        counters::ResourceFactory,
        images::{extent, layers_view, texture_format},
    },
    targets::CastTarget,
};
use slotmap::SlotMap;
use wgpu::{TextureAspect, TextureUsages, TextureViewDimension};

/// Hysteresis: a split layer stays split until the copy costs this much more than it saves, as
/// measured costs fluctuate.
const PATIENCE: f64 = 1.5;

/// Returns whether a layer to be redrawn should be split: something moves in it, and drawing the
/// rest would cost more than copying it. `shown` are the slots visible in it; `has_own` is whether
/// casters that the program draws are.
pub(crate) fn is_wanted(
    option: StillLayers,
    prices: &Prices,
    casters: &Casters,
    cast: &LightCast,
    shown: &ShownSlots,
    has_own: bool,
) -> bool {
    let texels = u64::from(cast.target.size.x) * u64::from(cast.target.size.y);
    if option == StillLayers::Never {
        return false;
    }
    let [still, moving] = triangles(casters, shown);
    if !has_own && moving == 0 {
        return false;
    }
    if option == StillLayers::Always {
        return true;
    }
    // The still casters are drawn once into their own layer, and then copied.
    let saved = still as f64 * prices.texels_a_triangle();
    let patience = if cast.still.is_some() { PATIENCE } else { 1.0 };
    saved * patience > texels as f64
}

/// Returns the numbers of triangles of the still and of the moving casters that may be visible in a
/// layer.
fn triangles(casters: &Casters, shown: &ShownSlots) -> [u64; 2] {
    let mut sums = [0; 2];
    for (_, mesh) in casters.meshes() {
        let counts = shown.count(mesh.slots(), casters.moving_flags());
        for (sum, count) in sums.iter_mut().zip(counts) {
            *sum += count * mesh.draw.triangles();
        }
    }
    sums
}

impl StillLayer {
    /// Returns an empty layer with the properties of a cast's.
    pub(crate) fn like_target(factory: &mut ResourceFactory<'_>, target: &CastTarget) -> Self {
        let label = "umbrage still casters";
        let format = texture_format(target.format());
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC;
        let texture = factory.texture(label, extent(target.size, 1), format, usage);
        let dimension = TextureViewDimension::D2;
        let layer = layers_view(&texture, label, dimension, TextureAspect::All, 0..1);
        Self {
            target: target.with_layer(layer),
            texture,
            is_stale: true,
        }
    }
}

/// Returns the bytes of a layer with the properties of a cast's.
pub(crate) fn bytes_of(target: &CastTarget) -> u64 {
    let texels = u64::from(target.size.x) * u64::from(target.size.y);
    texels * target.format().bytes() as u64
}

/// Returns the bytes of all layers of still casters.
pub(crate) fn still_bytes(lights: &SlotMap<LightKey, HeldLight>) -> u64 {
    let casts = lights.values().flat_map(|light| &light.maps.casts);
    let layers = casts.filter_map(|cast| cast.still.as_ref());
    layers.map(|still| bytes_of(&still.target)).sum()
}
