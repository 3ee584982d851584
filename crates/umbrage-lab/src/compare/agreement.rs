//! How well another backend agrees with the CPU.
//!
//! Devices move vertices to grids of 1/16 to 1/256 pixels, and some lay depth planes through the moved ones. That alone moves
//! edges, of shadows and of what is seen. So the CPU plays the recipe once more, rounding vertices as the other backend's device
//! does ([`Snapping`]), and that is what the other backend must agree with: on other grids the same answers are decided, no
//! fewer.

use crate::LabError;
use glam::{Vec2, Vec3};
use umbrage_core::{
    Backend, Cast, CastMode, Receivers, Recipe, Shadows, Snapping, View,
    metrics::{AGREEMENT_TOLERANCE, Agreement, Doubt},
};
use umbrage_cpu::{Cpu, CpuOptions, PlaneShift};

/// How far casts are moved in depth: 2^-20, 16 units in the last place of depths in 0.5..1.
const NUDGE_DEPTH: f32 = 1.0 / 1_048_576.0;

/// How near two surfaces are that may change places: where they meet at an outline they are seen edge-on, so that rounding is many
/// times that of other depths. 2^-16.
const NUDGE_SECOND: f32 = 1.0 / 65_536.0;

/// What becomes of surfaces that meet hangs on the last bits of their planes: moves that change these, as parts of
/// [`NUDGE_DEPTH`].
const LAST_BITS: [f32; 8] = [0.125, -0.125, 0.25, -0.25, 0.375, -0.375, 0.5, -0.5];

/// How triangles with even and with odd numbers are moved, as parts of what rounding may come to.
const PLANES: [(f32, f32); 4] = [(1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0)];

/// What a unit of polygon offset may be, as parts of the CPU's. Of floats it is the spacing at the primitive's greatest depth:
/// SwiftShader takes the greatest difference from one corner's, which may be half as much, and 1.01 steps of 16 bits for one.
const UNITS: [f32; 2] = [0.5, 2.0];

/// How far receivers are moved: a fraction of the greatest coordinate of any, 2^-21.
const NUDGE_POSITION: f32 = 1.0 / 2_097_152.0;

/// Compares a backend's mask with the one that the CPU makes when it rounds vertices so, too. `of_cpu` is what it makes of
/// the same recipe by its own rule; [`Agreement::differing`] and [`Agreement::largest`] tell the difference from that.
///
/// Pixels where the two see different triangles are set apart. Others that differ by more than is allowed are *undecided*
/// when the CPU's answer changes, too, as something moves by what rounding may come to; else they are violations. What moves:
/// casts sideways, by half a step of the grid; casts in depth, by 2^-20; each triangle in depth, by the bound of its plane's
/// error, which is great for slivers; the unit of polygon offset, by a factor of two; receivers, by 2^-21 of the greatest coordinate. Casts are
/// moved sideways and in depth at once, too.
/// Equal masks need no such nudges, so none are rendered for them.
///
/// # Errors
/// Errors if the CPU cannot play the recipe, or masks differ in size or hold anything outside 0..=1.
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
    /// Of triangles in depth, by parts of what rounding may come to for each.
    Planes(PlaneShift),
    /// Of every cast in depth, away from the light (1) or towards it (-1), by what rounding comes to.
    Depth(f32),
    /// Of the constants of polygon offsets, whose units are left to devices: a factor.
    Units(f32),
    /// Of the light spaces of those casts that keep what lies behind another image, in depth. Two surfaces that meet are as far
    /// apart as they are rounded, and the second of them may count or not. (Moved the other way, all lay behind themselves.)
    Behind(f32),
    /// Of receivers along their normals: a fraction of the greatest coordinate.
    Receivers(f32),
    /// Of every cast sideways (texels) and in depth, at once.
    Casts(Vec2, f32),
    /// Of receivers in this direction, by [`NUDGE_POSITION`] of the greatest coordinate.
    ReceiversAlong(Vec3),
}

/// What to try on a recipe. Half a step of the device's grid is as far as rounding moves a vertex; a device that rounds
/// another way (down, say) moves it as much further.
fn nudges(recipe: &Recipe, snapping: Snapping) -> Vec<Nudge> {
    let receivers = [NUDGE_POSITION, -NUDGE_POSITION].map(Nudge::Receivers);
    let along = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| [axis, -axis]);
    let along = along
        .as_flattened()
        .iter()
        .map(|d| Nudge::ReceiversAlong(*d));
    if recipe.casts.is_empty() {
        return receivers.into_iter().chain(along).collect();
    }
    let t = 0.5 * snapping.step();
    let sideways =
        [(t, t), (-t, t), (t, -t), (-t, -t)].map(|(x, y)| Nudge::Sideways(Vec2::new(x, y)));
    let in_depth = [1.0, -1.0].map(Nudge::Depth);
    let planes = PLANES.map(|(even, odd)| Nudge::Planes(PlaneShift { even, odd }));
    let mut out = [&sideways[..], &in_depth, &planes, &receivers].concat();
    if recipe.casts.iter().any(|cast| cast.bias.constant != 0) {
        out.extend(UNITS.map(Nudge::Units));
    }
    if recipe.casts.iter().any(is_behind) {
        out.push(Nudge::Behind(-NUDGE_SECOND));
        out.extend(LAST_BITS.map(Nudge::Depth));
    }
    // All of it is rounded at once, and less than at most: a tap crosses the edge of a texel while what it is compared with moves.
    for part in [1.0, 0.25] {
        for (x, y) in [(t, t), (-t, t), (t, -t), (-t, -t)] {
            let texels = part * Vec2::new(x, y);
            out.extend([part, -part].map(|depth| Nudge::Casts(texels, depth)));
        }
    }
    out.extend(along);
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
            Self::Planes(shift) => {
                let options = CpuOptions::default()
                    .snapping(cpu.snapping())
                    .plane_shift(shift);
                Cpu::with_options(&options)?.render(&known, recipe)?
            }
            Self::Depth(part) => {
                let by = |_: &Cast| (Vec2::ZERO, part * NUDGE_DEPTH);
                cpu.render(&known, &nudged(recipe, by))?
            }
            Self::Units(factor) => {
                let mut scaled = recipe.clone();
                for cast in &mut scaled.casts {
                    cast.bias.constant = (cast.bias.constant as f32 * factor).round() as i32;
                }
                cpu.render(&known, &scaled)?
            }
            Self::Behind(depth) => {
                let by = |cast: &Cast| (Vec2::ZERO, if is_behind(cast) { depth } else { 0.0 });
                cpu.render(&known, &nudged(recipe, by))?
            }
            Self::Casts(texels, part) => {
                let by = |_: &Cast| (texels, part * NUDGE_DEPTH);
                cpu.render(&known, &nudged(recipe, by))?
            }
            Self::Receivers(fraction) => match seen.map(|r| moved(r, |n| n * fraction)) {
                Some(moved) => cpu.render(&view.with_receivers(&moved), recipe)?,
                None => expected.clone(),
            },
            Self::ReceiversAlong(direction) => {
                match seen.map(|r| moved(r, |_| direction * NUDGE_POSITION)) {
                    Some(moved) => cpu.render(&view.with_receivers(&moved), recipe)?,
                    None => expected.clone(),
                }
            }
        })
    }
}

fn is_behind(cast: &Cast) -> bool {
    matches!(cast.mode, CastMode::DepthPeel(_))
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

/// Returns receivers moved by what `by` makes of their normals, times the greatest coordinate of any of them: the matrix that takes a receiver
/// near the origin to the light's space has a term of that size, too, and rounds as much.
fn moved(receivers: &Receivers, by: impl Fn(Vec3) -> Vec3) -> Receivers {
    let mut out = receivers.clone();
    let is_seen = |i: &usize| receivers.receives[*i];
    let sizes = (0..receivers.len()).filter(is_seen);
    let greatest = sizes
        .map(|i| receivers.position(i).abs().max_element())
        .fold(0.0, f32::max);
    for i in 0..out.len() {
        let p = out.position(i);
        let q = p + by(out.normal(i)) * greatest;
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
