//! Layers that hold the casters that are still, so that a frame in which one caster moves does not
//! draw all the others again: the layer is copied, and what moves is drawn on top. Depth tests keep
//! the nearest in any order, so the bits are those of drawing everything.
//!
//! A copy has a price, too: Godot's engine lost more by such copies than it gained on small scenes
//! (pull request 77683). So a layer is split only where what need not be drawn costs more than the
//! copy, by prices that are measured where the device has timestamps (`prices.rs`).

use crate::{
    light_set::{
        casters::Casters,
        culling::{ShownSlots, Wanted},
        options::{LightId, StillLayers},
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

/// A layer that is split stays so until the copy takes this much longer than what it saves:
/// measured prices waver.
const PATIENCE: f64 = 1.5;

/// Returns whether a layer that must be drawn again is to be split: whether something moves in it,
/// and drawing what doesn't would cost more than copying it. `shown` are the slots that show in it.
pub(crate) fn is_wanted(
    option: StillLayers,
    prices: &Prices,
    casters: &Casters,
    cast: &LightCast,
    shown: &ShownSlots,
) -> bool {
    let texels = u64::from(cast.target.size.x) * u64::from(cast.target.size.y);
    let moving = Wanted::Moving(casters.moving());
    if option == StillLayers::Never || triangles(casters, shown, moving) == 0 {
        return false;
    }
    if option == StillLayers::Always {
        return true;
    }
    // What is still is drawn once into its own layer, and then copied.
    let still = Wanted::Still(casters.moving());
    let saved = triangles(casters, shown, still) as f64 * prices.texels_a_triangle();
    let patience = if cast.still.is_some() { PATIENCE } else { 1.0 };
    saved * patience > texels as f64
}

/// Returns how many triangles of the wanted casters may show in a layer.
fn triangles(casters: &Casters, shown: &ShownSlots, wanted: Wanted<'_>) -> u64 {
    casters
        .meshes()
        .map(|(_, mesh)| shown.count(mesh.slots(), wanted) * mesh.draw.triangles())
        .sum()
}

impl StillLayer {
    /// Returns an empty layer like that of a cast.
    pub(crate) fn like(factory: &mut ResourceFactory<'_>, target: &CastTarget) -> Self {
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

/// Returns the bytes of a layer like that of a cast.
pub(crate) fn bytes_of(target: &CastTarget) -> u64 {
    let texels = u64::from(target.size.x) * u64::from(target.size.y);
    texels * target.format().bytes() as u64
}

/// Returns the bytes of all layers that hold still casters.
pub(crate) fn still_bytes(lights: &SlotMap<LightId, HeldLight>) -> u64 {
    let casts = lights.values().flat_map(|light| &light.maps.casts);
    let layers = casts.filter_map(|cast| cast.still.as_ref());
    layers.map(|still| bytes_of(&still.target)).sum()
}
