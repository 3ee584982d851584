//! How well another backend agrees with the CPU.
//!
//! Devices move vertices to grids of 1/16 to 1/256 pixels, and some lay depth planes through the moved ones. That alone moves
//! edges, of shadows and of what is seen. So the CPU plays the recipe once more, rounding vertices as the other backend's device
//! does ([`Snapping`]), and that is what the other backend must agree with: on other grids the same answers are decided, no
//! fewer.

use crate::LabError;
use glam::Vec2;
use umbrage_core::{
    Backend, Cast, CastMode, Receivers, Recipe, Shadows, Snapping, View,
    metrics::{AGREE, Agreement, Doubt},
};
use umbrage_cpu::{Cpu, CpuOptions};

/// How far their depth is moved: 2^-20, 16 units in the last place of depths in 0.5..1.
const NUDGE_DEPTH: f32 = 1.0 / 1_048_576.0;

/// How far receivers are moved where nothing is cast: a fraction of their greatest coordinate, 2^-21.
const NUDGE_POSITION: f32 = 1.0 / 2_097_152.0;

/// Compares a backend's mask with the one that the CPU makes when it rounds vertices so, too. `of_cpu` is what it makes of
/// the same recipe by its own rule; [`Agreement::differing`] and [`Agreement::largest`] tell the difference from that.
///
/// Pixels where the two see different triangles are set apart. Others that differ by more than is allowed are *undecided*
/// when the CPU's answer changes, too, as the casts' light spaces are nudged (sideways by half a step of the grid, in depth
/// by 2^-20; second surfaces alone, too), or, for recipes without casts, as its receivers are; else they are violations. Equal masks need no nudges, so
/// none are rendered for them.
///
/// # Errors
/// When the CPU cannot play the recipe, or masks differ in size or hold anything outside 0..=1.
pub fn agree(
    view: &View<'_>,
    recipe: &Recipe,
    of_cpu: &Shadows,
    other: &Shadows,
    snapping: Snapping,
) -> Result<Agreement, LabError> {
    let mut cpu = Cpu::with_options(&CpuOptions::default().snapping(snapping))?;
    let played = if snapping == cpu_rule() { None } else { Some(cpu.render(view, recipe)?) };
    let expected = played.as_ref().unwrap_or(of_cpu);
    let tolerance = recipe.receive.kernel.tolerance();
    let mut doubts = different_triangles(expected.receivers.as_ref(), other.receivers.as_ref(), expected.mask.len());
    let agreement =
        |doubts: &[Doubt]| Agreement::measure(expected.size, &expected.mask, &other.mask, doubts, tolerance);
    let mut agreed = agreement(&doubts)?;
    for nudge in nudges(recipe, snapping) {
        if agreed.holds() {
            break;
        }
        let nudged = nudge.render(&mut cpu, view, recipe, expected)?;
        for (doubt, (a, b)) in doubts.iter_mut().zip(expected.mask.iter().zip(&nudged.mask)) {
            if a != b && *doubt == Doubt::None {
                *doubt = Doubt::Rounding;
            }
        }
        agreed = agreement(&doubts)?;
    }
    let plain = Agreement::measure(of_cpu.size, &of_cpu.mask, &other.mask, &doubts, tolerance)?;
    let moved = |(a, b): (&f32, &f32)| (a - b).abs() > AGREE + tolerance;
    let by_grid = of_cpu.mask.iter().zip(&expected.mask).filter(|&pair| moved(pair)).count() as u64;
    Ok(Agreement { differing: plain.differing, largest: plain.largest, by_grid, ..agreed })
}

/// How the CPU rounds if it isn't told otherwise.
fn cpu_rule() -> Snapping {
    Snapping::default()
}

/// A movement too small to see.
#[derive(Clone, Copy, Debug)]
enum Nudge {
    /// Of every cast's light space: texels, and depth.
    Space(Vec2, f32),
    /// Of the light spaces of those casts that keep what lies behind another image, in depth. Two surfaces that meet are as far
    /// apart as they are rounded, and the second of them may count or not. (Moved the other way, all lay behind themselves.)
    Behind(f32),
    /// Of receivers along their normals: a fraction of their greatest coordinate.
    Receivers(f32),
}

/// What to try on a recipe. Half a step of the device's grid is as far as rounding moves a vertex; a device that rounds
/// another way (down, say) moves it as much further.
fn nudges(recipe: &Recipe, snapping: Snapping) -> Vec<Nudge> {
    if recipe.casts.is_empty() {
        return vec![Nudge::Receivers(NUDGE_POSITION), Nudge::Receivers(-NUDGE_POSITION)];
    }
    let t = 0.5 * snapping.step();
    let sideways = [(t, t), (-t, t), (t, -t), (-t, -t)].map(|(x, y)| Nudge::Space(Vec2::new(x, y), 0.0));
    let in_depth = [NUDGE_DEPTH, -NUDGE_DEPTH].map(|depth| Nudge::Space(Vec2::ZERO, depth));
    let peels = recipe.casts.iter().any(is_behind);
    let behind = if peels { vec![Nudge::Behind(-NUDGE_DEPTH)] } else { Vec::new() };
    [&sideways[..], &in_depth, &behind].concat()
}

impl Nudge {
    /// The recipe, moved so; what the CPU saw is known.
    fn render(self, cpu: &mut Cpu, view: &View<'_>, recipe: &Recipe, expected: &Shadows) -> Result<Shadows, LabError> {
        let seen = expected.receivers.as_ref().or(view.receivers);
        Ok(match self {
            Self::Space(texels, depth) => {
                let view = seen.map_or(*view, |r| view.with_receivers(r));
                cpu.render(&view, &nudged(recipe, texels, depth, |_| true))?
            }
            Self::Behind(depth) => {
                let view = seen.map_or(*view, |r| view.with_receivers(r));
                cpu.render(&view, &nudged(recipe, Vec2::ZERO, depth, is_behind))?
            }
            Self::Receivers(fraction) => match seen.map(|r| moved(r, fraction)) {
                Some(moved) => cpu.render(&view.with_receivers(&moved), recipe)?,
                None => expected.clone(),
            },
        })
    }
}

fn is_behind(cast: &Cast) -> bool {
    matches!(cast.mode, CastMode::Behind(_))
}

/// The recipe with the light spaces of these casts moved; the lookup stays.
fn nudged(recipe: &Recipe, texels: Vec2, depth: f32, which: impl Fn(&Cast) -> bool) -> Recipe {
    let mut nudged = recipe.clone();
    for cast in nudged.casts.iter_mut().filter(|cast| which(cast)) {
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
