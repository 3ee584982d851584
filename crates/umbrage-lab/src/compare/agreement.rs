//! Which of the CPU's answers hang on rounding, and how well another backend agrees on the rest.

use crate::LabError;
use glam::Vec2;
use umbrage_core::{
    Backend, Receivers, Recipe, Shadows, View,
    metrics::{Agreement, Doubt},
};

/// How far light spaces are moved, texels: half of the finest sub-pixel grid's step (1/256) that drivers snap vertices to.
const NUDGE_TEXELS: f32 = 1.0 / 512.0;

/// How far their depth is moved: 2^-20, 16 units in the last place of depths in 0.5..1.
const NUDGE_DEPTH: f32 = 1.0 / 1_048_576.0;

/// How far receivers are moved where nothing is cast: a fraction of their greatest coordinate, 2^-21.
const NUDGE_POSITION: f32 = 1.0 / 2_097_152.0;

/// Compares another backend's mask with the CPU's. Pixels where the two see different triangles are set apart. Others that
/// differ by more than is allowed are *undecided* when the CPU's answer changes, too, as the casts' light spaces are nudged
/// (sideways by 1/512 texel, in depth by 2^-20), or, for recipes without casts, as its receivers are; else they are
/// violations. Equal masks need no nudges, so none are rendered for them.
pub(crate) fn compare(
    cpu: &mut dyn Backend,
    view: &View<'_>,
    recipe: &Recipe,
    of_cpu: &Shadows,
    other: &Shadows,
) -> Result<Agreement, LabError> {
    let tolerance = recipe.receive.kernel.tolerance();
    let mut doubts = different_triangles(of_cpu.receivers.as_ref(), other.receivers.as_ref(), of_cpu.mask.len());
    let agreement = |doubts: &[Doubt]| Agreement::measure(of_cpu.size, &of_cpu.mask, &other.mask, doubts, tolerance);
    let mut agreed = agreement(&doubts)?;
    for nudge in nudges(recipe) {
        if agreed.holds() {
            break;
        }
        let nudged = nudge.render(cpu, view, recipe, of_cpu)?;
        for (doubt, (a, b)) in doubts.iter_mut().zip(of_cpu.mask.iter().zip(&nudged.mask)) {
            if a != b && *doubt == Doubt::None {
                *doubt = Doubt::Rounding;
            }
        }
        agreed = agreement(&doubts)?;
    }
    Ok(agreed)
}

/// A movement too small to see.
#[derive(Clone, Copy, Debug)]
enum Nudge {
    /// Of every cast's light space: texels, and depth.
    Space(Vec2, f32),
    /// Of receivers along their normals: a fraction of their greatest coordinate.
    Receivers(f32),
}

/// What to try on a recipe.
fn nudges(recipe: &Recipe) -> Vec<Nudge> {
    if recipe.casts.is_empty() {
        return vec![Nudge::Receivers(NUDGE_POSITION), Nudge::Receivers(-NUDGE_POSITION)];
    }
    let t = NUDGE_TEXELS;
    let sideways = [(t, t), (-t, t), (t, -t), (-t, -t)].map(|(x, y)| Nudge::Space(Vec2::new(x, y), 0.0));
    let in_depth = [NUDGE_DEPTH, -NUDGE_DEPTH].map(|depth| Nudge::Space(Vec2::ZERO, depth));
    [&sideways[..], &in_depth].concat()
}

impl Nudge {
    /// The recipe, moved so; what the CPU saw is known.
    fn render(
        self,
        cpu: &mut dyn Backend,
        view: &View<'_>,
        recipe: &Recipe,
        of_cpu: &Shadows,
    ) -> Result<Shadows, LabError> {
        let seen = of_cpu.receivers.as_ref().or(view.receivers);
        Ok(match self {
            Self::Space(texels, depth) => {
                let view = seen.map_or(*view, |r| view.with_receivers(r));
                cpu.render(&view, &nudged(recipe, texels, depth))?
            }
            Self::Receivers(fraction) => match seen.map(|r| moved(r, fraction)) {
                Some(moved) => cpu.render(&view.with_receivers(&moved), recipe)?,
                None => of_cpu.clone(),
            },
        })
    }
}

/// The recipe with every cast's light space moved; the lookup stays.
fn nudged(recipe: &Recipe, texels: Vec2, depth: f32) -> Recipe {
    let mut nudged = recipe.clone();
    for cast in &mut nudged.casts {
        cast.space = cast.space.nudged(texels, depth, recipe.images[cast.image].size);
    }
    nudged
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

fn different_triangles(a: Option<&Receivers>, b: Option<&Receivers>, len: usize) -> Vec<Doubt> {
    let (Some(a), Some(b)) = (a, b) else { return vec![Doubt::None; len] };
    if a.len() != len || b.len() != len {
        return vec![Doubt::None; len];
    }
    (0..len).map(|i| if a.triangle[i] == b.triangle[i] { Doubt::None } else { Doubt::Triangle }).collect()
}
