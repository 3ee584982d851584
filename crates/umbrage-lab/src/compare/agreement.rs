//! How well another backend agrees with the CPU.
//!
//! Devices move vertices to grids of 1/16 to 1/256 pixels, and some lay depth planes through the moved ones. That alone moves
//! edges, of shadows and of what is seen. So the CPU plays the recipe once more, rounding vertices as the other backend's device
//! does ([`Snapping`]), and that is what the other backend must agree with: on other grids the same answers are decided, no
//! fewer.

use crate::LabError;
use glam::Vec2;
use umbrage_core::{
    Backend, Cast, CastMode, Format, Receivers, Recipe, Shadows, Snapping, View,
    metrics::{AGREEMENT_TOLERANCE, Agreement, Doubt},
};
use umbrage_cpu::{Cpu, CpuOptions};

/// How far casts are moved in depth: 2^-20, 16 units in the last place of depths in 0.5..1.
const NUDGE_DEPTH: f32 = 1.0 / 1_048_576.0;

/// How near two surfaces are that may change places: where they meet at an outline they are seen edge-on, so that rounding is many
/// times that of other depths. 2^-16.
const NUDGE_SECOND: f32 = 1.0 / 65_536.0;

/// What becomes of surfaces that meet hangs on the last bits of their planes: moves that change these, as parts of
/// [`NUDGE_DEPTH`].
const LAST_BITS: [f32; 8] = [0.125, -0.125, 0.25, -0.25, 0.375, -0.375, 0.5, -0.5];

/// How far receivers are moved where nothing is cast: a fraction of their greatest coordinate, 2^-21.
const NUDGE_POSITION: f32 = 1.0 / 2_097_152.0;

/// Compares a backend's mask with the one that the CPU makes when it rounds vertices so, too. `of_cpu` is what it makes of
/// the same recipe by its own rule; [`Agreement::differing`] and [`Agreement::largest`] tell the difference from that.
///
/// Pixels where the two see different triangles are set apart. Others that differ by more than is allowed are *undecided*
/// when the CPU's answer changes, too, as casts are nudged (sideways by half a step of the grid; in depth by 2^-20; in what
/// graphics APIs leave open), or, for recipes without casts, as its receivers are; else they are
/// violations. Equal masks need no nudges, so none are rendered for them.
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
    let played = if snapping == cpu_rule() {
        None
    } else {
        Some(cpu.render(view, recipe)?)
    };
    let expected = played.as_ref().unwrap_or(of_cpu);
    let tolerance = recipe.receive.kernel.tolerance();
    let mut doubts = different_triangles(
        expected.receivers.as_ref(),
        other.receivers.as_ref(),
        expected.mask.len(),
    );
    let agreement = |doubts: &[Doubt]| {
        Agreement::measure(
            expected.size,
            &expected.mask,
            &other.mask,
            doubts,
            tolerance,
        )
    };
    let mut agreed = agreement(&doubts)?;
    for nudge in nudges(recipe, snapping) {
        if agreed.holds() {
            break;
        }
        let nudged = nudge.render(&mut cpu, view, recipe, expected)?;
        for (doubt, (a, b)) in doubts
            .iter_mut()
            .zip(expected.mask.iter().zip(&nudged.mask))
        {
            if a != b && *doubt == Doubt::None {
                *doubt = Doubt::Rounding;
            }
        }
        agreed = agreement(&doubts)?;
    }
    let plain = Agreement::measure(of_cpu.size, &of_cpu.mask, &other.mask, &doubts, tolerance)?;
    let moved = |(a, b): (&f32, &f32)| (a - b).abs() > AGREEMENT_TOLERANCE + tolerance;
    let by_grid = of_cpu
        .mask
        .iter()
        .zip(&expected.mask)
        .filter(|&pair| moved(pair))
        .count() as u64;
    Ok(Agreement {
        differing: plain.differing,
        largest: plain.largest,
        by_grid,
        ..agreed
    })
}

/// How the CPU rounds if it isn't told otherwise.
fn cpu_rule() -> Snapping {
    Snapping::default()
}

/// A movement too small to see.
#[derive(Clone, Copy, Debug)]
enum Nudge {
    /// Of every cast's light space sideways, texels.
    Sideways(Vec2),
    /// Of every cast in depth, away from the light (1) or towards it (-1), by what rounding comes to.
    Depth(f32),
    /// Of polygon offsets in 16 bits, whose units are left to devices: one step of 2^-16 instead of two.
    HalfUnits,
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
        return vec![
            Nudge::Receivers(NUDGE_POSITION),
            Nudge::Receivers(-NUDGE_POSITION),
        ];
    }
    let t = 0.5 * snapping.step();
    let sideways =
        [(t, t), (-t, t), (t, -t), (-t, -t)].map(|(x, y)| Nudge::Sideways(Vec2::new(x, y)));
    let in_depth = [1.0, -1.0].map(Nudge::Depth);
    let mut out = [&sideways[..], &in_depth].concat();
    if recipe.casts.iter().any(|cast| has_units(cast, recipe)) {
        out.push(Nudge::HalfUnits);
    }
    if recipe.casts.iter().any(is_behind) {
        out.push(Nudge::Behind(-NUDGE_SECOND));
        out.extend(LAST_BITS.map(Nudge::Depth));
    }
    out
}

impl Nudge {
    /// The recipe, moved so; what the CPU saw is known.
    fn render(
        self,
        cpu: &mut Cpu,
        view: &View<'_>,
        recipe: &Recipe,
        expected: &Shadows,
    ) -> Result<Shadows, LabError> {
        let seen = expected.receivers.as_ref().or(view.receivers);
        let known = seen.map_or(*view, |r| view.with_receivers(r));
        Ok(match self {
            Self::Sideways(texels) => cpu.render(&known, &nudged(recipe, |_| (texels, 0.0)))?,
            Self::Depth(part) => {
                let by = |cast: &Cast| (Vec2::ZERO, part * depth_rounding(cast, recipe));
                cpu.render(&known, &nudged(recipe, by))?
            }
            Self::HalfUnits => {
                let mut halved = recipe.clone();
                halved
                    .casts
                    .iter_mut()
                    .filter(|cast| has_units(cast, recipe))
                    .for_each(|cast| cast.bias.constant /= 2);
                cpu.render(&known, &halved)?
            }
            Self::Behind(depth) => {
                let by = |cast: &Cast| (Vec2::ZERO, if is_behind(cast) { depth } else { 0.0 });
                cpu.render(&known, &nudged(recipe, by))?
            }
            Self::Receivers(fraction) => match seen.map(|r| moved(r, fraction)) {
                Some(moved) => cpu.render(&view.with_receivers(&moved), recipe)?,
                None => expected.clone(),
            },
        })
    }
}

fn is_behind(cast: &Cast) -> bool {
    matches!(cast.mode, CastMode::DepthPeel(_))
}

/// Whether a cast's depth hangs on what a device takes for a unit of polygon offset. Vulkan leaves that open for fixed point:
/// of 16 bits, Mesa's software drivers take 2^-15, SwiftShader takes 1.01 times 2^-16.
fn has_units(cast: &Cast, recipe: &Recipe) -> bool {
    cast.bias.constant != 0 && recipe.images[cast.image].format == Format::Depth16
}

/// How far apart devices may be in a cast's depth by rounding. For floats, a unit of polygon offset is the last place of a
/// primitive's greatest depth, on some before it is clipped, when it may be many times 1: up to 8 here.
fn depth_rounding(cast: &Cast, recipe: &Recipe) -> f32 {
    let units = if has_units(cast, recipe) {
        0.0
    } else {
        cast.bias.constant as f32
    };
    NUDGE_DEPTH + units.abs() * (8.0 * f32::EPSILON)
}

/// The recipe with each cast's light space moved so, texels and depth; the lookup stays.
fn nudged(recipe: &Recipe, by: impl Fn(&Cast) -> (Vec2, f32)) -> Recipe {
    let mut nudged = recipe.clone();
    for cast in &mut nudged.casts {
        let (texels, depth) = by(cast);
        cast.space = cast
            .space
            .nudged(texels, depth, recipe.images[cast.image].size);
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
    let (Some(a), Some(b)) = (a, b) else {
        return vec![Doubt::None; len];
    };
    if a.len() != len || b.len() != len {
        return vec![Doubt::None; len];
    }
    (0..len)
        .map(|i| {
            if a.triangle[i] == b.triangle[i] {
                Doubt::None
            } else {
                Doubt::Triangle
            }
        })
        .collect()
}
