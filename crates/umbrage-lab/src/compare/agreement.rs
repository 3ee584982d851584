//! Which of the CPU's answers hang on rounding, and how well another backend agrees on the rest.

use crate::LabError;
use glam::Vec2;
use umbrage_core::{Backend, Receivers, Recipe, Shadows, View, metrics::Agreement};

/// How far light spaces are moved, texels: half of the finest sub-pixel grid's step (1/256) that drivers snap vertices to.
const NUDGE_TEXELS: f32 = 1.0 / 512.0;

/// How far their depth is moved: 2^-20, 16 units in the last place of depths in 0.5..1.
const NUDGE_DEPTH: f32 = 1.0 / 1_048_576.0;

/// How far receivers are moved where nothing is cast: a fraction of their greatest coordinate, 2^-21.
const NUDGE_POSITION: f32 = 1.0 / 2_097_152.0;

/// A pixel is undecided when the CPU's answer changes as the casts' light spaces are nudged (sideways by 1/512 texel, in
/// depth by 2^-20), or, for recipes without casts, as its receiver is; or when the backends see different receivers there.
pub(crate) fn compare(
    cpu: &mut dyn Backend,
    view: &View<'_>,
    recipe: &Recipe,
    of_cpu: &Shadows,
    other: &Shadows,
) -> Result<Agreement, LabError> {
    let mut undecided = different_receivers(of_cpu.receivers.as_ref(), other.receivers.as_ref(), of_cpu.mask.len());
    let mut mark = |nudged: &Shadows| {
        for (u, (a, b)) in undecided.iter_mut().zip(of_cpu.mask.iter().zip(&nudged.mask)) {
            *u |= a != b;
        }
    };
    if recipe.casts.is_empty() {
        for sign in [-1.0, 1.0] {
            if let Some(receivers) = of_cpu.receivers.as_ref().map(|r| moved(r, sign * NUDGE_POSITION)) {
                mark(&cpu.render(&view.with_receivers(&receivers), recipe)?);
            }
        }
    } else {
        for nudged in nudged_recipes(recipe) {
            mark(&cpu.render(view, &nudged)?);
        }
    }
    Ok(Agreement::measure(of_cpu.size, &of_cpu.mask, &other.mask, &undecided, recipe.receive.kernel.tolerance())?)
}

/// The recipe with every cast's light space moved; the lookup stays.
fn nudged_recipes(recipe: &Recipe) -> impl Iterator<Item = Recipe> {
    let t = NUDGE_TEXELS;
    let sideways = [Vec2::new(t, t), Vec2::new(-t, t), Vec2::new(t, -t), Vec2::new(-t, -t)].map(|n| (n, 0.0));
    let in_depth = [(Vec2::ZERO, NUDGE_DEPTH), (Vec2::ZERO, -NUDGE_DEPTH)];
    sideways.into_iter().chain(in_depth).map(|(texels, depth)| {
        let mut nudged = recipe.clone();
        for cast in &mut nudged.casts {
            cast.space = cast.space.nudged(texels, depth, recipe.images[cast.image].size);
        }
        nudged
    })
}

/// Receivers moved along their normals by a fraction of their greatest coordinate.
fn moved(receivers: &Receivers, fraction: f32) -> Receivers {
    let mut out = receivers.clone();
    for i in 0..out.len() {
        let p = out.position(i);
        let q = p + out.normal(i) * (p.abs().max_element() * fraction);
        (out.x[i], out.y[i], out.z[i]) = (q.x, q.y, q.z);
    }
    out
}

fn different_receivers(a: Option<&Receivers>, b: Option<&Receivers>, len: usize) -> Vec<bool> {
    let (Some(a), Some(b)) = (a, b) else { return vec![false; len] };
    if a.len() != len || b.len() != len {
        return vec![false; len];
    }
    (0..len).map(|i| a.triangle[i] != b.triangle[i]).collect()
}
