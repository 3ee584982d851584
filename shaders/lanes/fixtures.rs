//! A map and receivers for the lane tests.

use crate::{
    lanes::batch::{BATCH, Batch},
    shadow_map::texel_compare::DepthMap,
};

/// Side of the map, texels.
pub(crate) const SIZE: i32 = 37;
/// Number of layers.
pub(crate) const LAYERS: i32 = 2;

/// Returns depths 0..1 in pseudo-random order.
pub(crate) fn texels() -> Vec<f32> {
    let value = |i: i32| (i.wrapping_mul(7919) % 1009) as f32 / 1009.0;
    (0..SIZE * SIZE * LAYERS).map(value).collect()
}

/// Returns the texels as a map.
pub(crate) fn map(texels: &[f32], clamped: bool) -> DepthMap<'_> {
    DepthMap {
        texels,
        size: SIZE,
        packed: false,
        clamped,
        sample_gain: 1.0,
    }
}

/// Returns receivers on the map, at its edges and outside it, on level or steep planes. Some are
/// beyond the far plane. Every fifth isn't covered.
pub(crate) fn batch(turn: usize, is_sloped: bool) -> Batch {
    let mut batch = Batch::new();
    for i in 0..BATCH {
        let k = (turn * BATCH + i) as f32;
        batch.x[i] = (k * 0.73) % 45.0 - 4.0;
        batch.y[i] = (k * 1.37) % 45.0 - 4.0;
        batch.depth[i] = (k * 0.11) % 1.1;
        batch.deepest[i] = 1.0;
        if is_sloped {
            batch.deepest[i] = 0.9;
            batch.right[i] = (k * 0.017) % 0.4 - 0.2;
            batch.down[i] = if i % 3 == 0 { 0.0 } else { 0.15 };
        }
        batch.layer[i] = i as i32 % LAYERS;
        batch.covered[i] = i % 5 != 0;
    }
    batch
}
