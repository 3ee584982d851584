//! Perturbations of a recipe within rounding errors, as rendered by the CPU.
//!
//! A pixel is *decided* if no perturbation changes the CPU's result by a quarter of the difference
//! or more (for filtered images: at all). Perturbations are applied alone and in combination:
//!
//! * maps by half a grid step sideways,
//! * vertices by other summation orders,
//! * each triangle's depth by the error bound of its plane,
//! * units of polygon offset halved or doubled,
//! * receivers by 2^-21 of their coordinates,
//! * normals and filter results by some units in the last place.
//!
//! If masks agree, nothing is perturbed.

use crate::error::LabError;
use glam::{Vec2, Vec3, Vec4};
use umbrage_core::{
    Backend, Cast, CastMode, LightSpace, Receivers, Recipe, Shadows, Snapping, View,
};
use umbrage_cpu::{Cpu, CpuOptions, PlaneShift, VertexSums};

/// Depth shift of casts: 2^-20, 16 units in the last place of depths in 0.5..1.
const NUDGE_DEPTH: f32 = 1.0 / 1_048_576.0;

/// Distance of two surfaces whose order may change: 2^-16. Where they meet at an outline they are
/// seen edge-on, which amplifies rounding many times.
const NUDGE_SECOND: f32 = 1.0 / 65_536.0;

/// Shifts that change the last bits of planes, relative to [`NUDGE_DEPTH`]. They decide which of
/// two touching surfaces is nearer.
const LAST_BITS: [f32; 8] = [0.125, -0.125, 0.25, -0.25, 0.375, -0.375, 0.5, -0.5];

/// Shifts of triangles with even and with odd indices, relative to the bound of rounding.
const PLANES: [(f32, f32); 4] = [(1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0)];

/// Units of polygon offset on devices, relative to the CPU's.
///
/// For floats a unit is the spacing at the primitive's greatest depth. SwiftShader uses the
/// greatest difference from one corner's depth, which may be half as much. For 16-bit images it
/// uses 1.01 steps.
const UNITS: [f32; 2] = [0.5, 2.0];

/// Shift of receivers, relative to the greatest coordinate: 2^-21.
const NUDGE_POSITION: f32 = 1.0 / 2_097_152.0;

/// Rotation of receiver normals: 2^-22, 4 units in the last place of components in 0.5..1.
const NUDGE_NORMAL: f32 = 1.0 / 4_194_304.0;

/// Relative change of filter results: 2^-21. A mean of seven texels is rounded seven times by half
/// a unit in the last place: 3.5 * 2^-23.
const NUDGE_FILTERED: f32 = 1.0 / 2_097_152.0;

/// Signs of the channels' changes. Moments are subtracted from each other: if almost all depths are
/// equal, their last bits decide the difference.
const CHANNELS: [[f32; 4]; 4] = [
    [1.0, -1.0, 1.0, -1.0],
    [-1.0, 1.0, -1.0, 1.0],
    [1.0, 1.0, -1.0, -1.0],
    [-1.0, -1.0, 1.0, 1.0],
];

/// A set of simultaneous perturbations within rounding.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nudge {
    /// Summation order of vertex transforms. Far from the origin their products cancel out, so that
    /// rounding moves vertices by more than a grid step.
    sums: VertexSums,
    /// Depth shift of triangles, relative to each triangle's bound.
    planes: PlaneShift,
    /// Lateral shift of every cast's light space, texels.
    texels: Vec2,
    /// Depth shift of every cast, away from the light.
    depth: f32,
    /// Shift of casts without perspective, as shares (-1..=1) of the rounding bound of a receiver's
    /// transform ([`lookup_rounding`]). Far from the origin that is more than half a grid step.
    lookup: Vec3,
    /// Depth shift of casts that keep what is behind another image. Touching surfaces are separated
    /// only by rounding, so that the second may count or not.
    behind: f32,
    /// Factor of the constants of polygon offsets, whose units depend on the device.
    units: Option<f32>,
    /// Shift of receivers, relative to their greatest coordinate.
    receivers: Option<Direction>,
    /// Relative change of each channel of filter results.
    filtered: Vec4,
    /// Change of receiver normals. For a plane at grazing light, the values computed from them are
    /// small differences of products.
    normals: Vec3,
}

/// Shift of receivers, relative to the greatest coordinate.
#[derive(Clone, Copy, Debug)]
enum Direction {
    /// Along their normals.
    Normal(f32),
    /// In one direction.
    Fixed(Vec3),
}

/// No perturbation.
const NO_NUDGE: Nudge = Nudge {
    sums: VertexSums::InOrder,
    planes: PlaneShift::NONE,
    texels: Vec2::ZERO,
    depth: 0.0,
    lookup: Vec3::ZERO,
    behind: 0.0,
    units: None,
    receivers: None,
    filtered: Vec4::ZERO,
    normals: Vec3::ZERO,
};

/// Other summation orders of a transform. Nothing is fused, as products are guarded.
const OTHER_ORDERS: [VertexSums; 2] = [VertexSums::Reversed, VertexSums::Paired];

/// Returns the perturbations of a recipe: single ones first, then combinations.
pub(super) fn nudges(recipe: &Recipe, snapping: Snapping) -> Vec<Nudge> {
    if recipe.casts.is_empty() {
        let moved = along_directions(1.0, VertexSums::InOrder);
        return along_normals().into_iter().chain(moved).collect();
    }
    let mut out = of_casts(recipe, snapping);
    out.extend(along_normals());
    out.extend(nudges_together(recipe, snapping));
    out
}

/// Returns single perturbations of a recipe's casts and of results computed from them.
fn of_casts(recipe: &Recipe, snapping: Snapping) -> Vec<Nudge> {
    let mut out = Vec::new();
    out.extend(corners(snapping).map(|texels| Nudge { texels, ..NO_NUDGE }));
    out.extend([1.0, -1.0].map(in_depth));
    out.extend(PLANES.map(|(even, odd)| Nudge {
        planes: PlaneShift { even, odd },
        ..NO_NUDGE
    }));
    out.extend(OTHER_ORDERS.map(|sums| Nudge { sums, ..NO_NUDGE }));
    if recipe.casts.iter().any(|cast| cast.bias.constant != 0) {
        out.extend(UNITS.map(|units| Nudge {
            units: Some(units),
            ..NO_NUDGE
        }));
    }
    if !recipe.filters.is_empty() {
        out.extend(CHANNELS.map(|signs| Nudge {
            filtered: NUDGE_FILTERED * Vec4::from(signs),
            ..NO_NUDGE
        }));
    }
    if recipe.casts.iter().any(is_behind) {
        // The opposite shift would put each surface behind itself.
        out.push(Nudge {
            behind: -NUDGE_SECOND,
            ..NO_NUDGE
        });
        out.extend(LAST_BITS.map(in_depth));
    }
    out
}

/// Returns combinations, since devices round all values at once. A tap may cross a texel's edge
/// while its reference depth moves. Smaller shares matter, too: a result may change within a shift
/// and be equal at both ends.
fn nudges_together(recipe: &Recipe, snapping: Snapping) -> Vec<Nudge> {
    let mut out = Vec::new();
    for part in [1.0, 0.25] {
        for corner in corners(snapping) {
            out.extend([part, -part].map(|depth| Nudge {
                texels: part * corner,
                ..in_depth(depth)
            }));
        }
    }
    out.extend(along_directions(1.0, VertexSums::InOrder));
    out.extend(directions().into_iter().map(|direction| Nudge {
        normals: NUDGE_NORMAL * direction,
        ..NO_NUDGE
    }));
    for sums in OTHER_ORDERS {
        out.extend(along_directions(1.0, sums));
    }
    for sums in [VertexSums::InOrder].into_iter().chain(OTHER_ORDERS) {
        out.extend(along_directions(0.25, sums));
        for part in [1.0, 0.25] {
            out.extend(directions().into_iter().map(|direction| Nudge {
                sums,
                lookup: part * direction,
                ..NO_NUDGE
            }));
        }
    }
    if recipe.casts.iter().any(is_behind) {
        // Each order of sums changes the last bits, which decide between touching surfaces.
        for sums in OTHER_ORDERS {
            out.extend(LAST_BITS.map(|part| Nudge {
                sums,
                ..in_depth(part)
            }));
        }
    }
    out
}

/// Returns a depth shift of all casts by a multiple of [`NUDGE_DEPTH`].
fn in_depth(part: f32) -> Nudge {
    Nudge {
        depth: part * NUDGE_DEPTH,
        ..NO_NUDGE
    }
}

/// Returns shifts of receivers along their normals in both directions.
fn along_normals() -> [Nudge; 2] {
    [NUDGE_POSITION, -NUDGE_POSITION].map(|part| Nudge {
        receivers: Some(Direction::Normal(part)),
        ..NO_NUDGE
    })
}

/// Returns shifts of receivers in all directions by a multiple of [`NUDGE_POSITION`], with this
/// order of sums.
fn along_directions(part: f32, sums: VertexSums) -> impl Iterator<Item = Nudge> {
    directions().into_iter().map(move |direction| Nudge {
        sums,
        receivers: Some(Direction::Fixed(part * NUDGE_POSITION * direction)),
        ..NO_NUDGE
    })
}

/// Returns shifts by half a grid step to all sides, texels: the maximum shift of a vertex by
/// rounding. A device that rounds down shifts it by that much more.
fn corners(snapping: Snapping) -> [Vec2; 4] {
    let t = 0.5 * snapping.step();
    [(t, t), (-t, t), (t, -t), (-t, -t)].map(|(x, y)| Vec2::new(x, y))
}

/// Returns the 26 steps from a cube to its neighbours. A step along an axis crosses a texel's edge,
/// a diagonal one its corner.
fn directions() -> Vec<Vec3> {
    let steps = [-1.0, 0.0, 1.0];
    let cubes = steps.map(|x| steps.map(|y| steps.map(|z| Vec3::new(x, y, z))));
    let all = cubes.as_flattened().as_flattened().iter().copied();
    all.filter(|step| *step != Vec3::ZERO).collect()
}

impl Nudge {
    /// Returns the CPU's result of the perturbed recipe. The visible receivers are known.
    pub(super) fn render(
        &self,
        cpu: &mut Cpu,
        view: &View<'_>,
        recipe: &Recipe,
        expected: &Shadows,
    ) -> Result<Shadows, LabError> {
        let seen = expected.receivers.as_ref().or(view.receivers);
        let has_lookup = self.lookup != Vec3::ZERO;
        let greatest = seen.filter(|_| has_lookup).map_or(0.0, greatest_coordinate);
        let recipe = self.recipe(recipe, greatest);
        let mut moved = seen
            .zip(self.receivers)
            .map(|(seen, direction)| match direction {
                Direction::Normal(part) => move_receivers(seen, |normal| normal * part),
                Direction::Fixed(by) => move_receivers(seen, |_| by),
            });
        if self.normals != Vec3::ZERO {
            moved = moved.or_else(|| seen.cloned());
            moved = moved.map(|receivers| turn_receivers(receivers, self.normals));
        }
        let view = moved
            .as_ref()
            .or(seen)
            .map_or(*view, |receivers| view.with_receivers(receivers));
        let plain = CpuOptions::default().snapping(cpu.snapping());
        let options = plain
            .plane_shift(self.planes)
            .vertex_sums(self.sums)
            .filter_shift(self.filtered);
        if options == plain {
            return Ok(cpu.render(&view, &recipe)?);
        }
        Ok(Cpu::with_options(&options)?.render(&view, &recipe)?)
    }

    /// Returns the recipe with the light space of each cast perturbed; the lookup is unchanged. No
    /// coordinate of a receiver exceeds `greatest`.
    fn recipe(&self, recipe: &Recipe, greatest: f32) -> Recipe {
        let mut nudged = recipe.clone();
        for cast in &mut nudged.casts {
            let behind = if is_behind(cast) { self.behind } else { 0.0 };
            let size = recipe.images[cast.image].size;
            let by = self.lookup * lookup_rounding(&cast.space, greatest);
            let texels = self.texels + 0.5 * by.truncate() * size.as_vec2();
            cast.space = cast
                .space
                .nudge_by(texels, self.depth + behind + by.z, size);
            if let Some(units) = self.units {
                cast.bias.constant = (cast.bias.constant as f32 * units).round() as i32;
            }
        }
        nudged
    }
}

fn is_behind(cast: &Cast) -> bool {
    matches!(cast.mode, CastMode::DepthPeel(_))
}

/// Returns the rounding bound of a receiver's clip x, y and z; 0 with perspective.
///
/// On each of two devices, three sums are each rounded by half a unit in the last place of the
/// greatest sum. Another half unit accounts for a fused product.
fn lookup_rounding(space: &LightSpace, greatest: f32) -> Vec3 {
    let m = space.clip_from_world();
    if m.row(3) != Vec4::W {
        return Vec3::ZERO;
    }
    let terms = greatest * (m.x_axis.abs() + m.y_axis.abs() + m.z_axis.abs()) + m.w_axis.abs();
    3.5 * f32::EPSILON * terms.truncate()
}

fn greatest_coordinate(receivers: &Receivers) -> f32 {
    let seen = (0..receivers.len()).filter(|&i| receivers.receives[i]);
    seen.map(|i| receivers.position(i).abs().max_element())
        .fold(0.0, f32::max)
}

/// Returns receivers shifted by `by` of their normals, times the greatest coordinate of any
/// receiver. For receivers near the origin, the light matrix has a term of that size, too, and
/// rounds as much.
fn move_receivers(receivers: &Receivers, by: impl Fn(Vec3) -> Vec3) -> Receivers {
    let mut out = receivers.clone();
    let greatest = greatest_coordinate(receivers);
    for i in 0..out.len() {
        let p = out.position(i);
        let q = p + by(out.normal(i)) * greatest;
        (out.x[i], out.y[i], out.z[i]) = (q.x, q.y, q.z);
    }
    out
}

/// Returns receivers with `by` added to their normals.
fn turn_receivers(mut receivers: Receivers, by: Vec3) -> Receivers {
    for i in 0..receivers.len() {
        let n = receivers.normal(i) + by;
        (receivers.nx[i], receivers.ny[i], receivers.nz[i]) = (n.x, n.y, n.z);
    }
    receivers
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage_core::{Geometry, ShadowTechnique as _};
    use umbrage_techniques::{Hard, MapTechnique, Midpoint, Traced};

    fn with_view<R>(f: impl FnOnce(&View<'_>) -> R) -> R {
        let scene = umbrage_scenes::by_argument("cubes").expect("a built-in scene");
        let geometry = Geometry::bake(&scene).expect("valid");
        f(&View::new(&scene.cameras[0], &scene.lights[0], &geometry))
    }

    #[test]
    fn without_casts_receivers_move_alone() {
        let recipe = with_view(|view| Traced::default().recipe(view)).expect("supported");
        let nudges = nudges(&recipe, Snapping::default());
        assert_eq!(nudges.len(), 2 + 26);
        assert!(nudges.iter().all(|nudge| nudge.receivers.is_some()));
    }

    #[test]
    fn only_peeled_casts_move_behind() {
        let recipe =
            with_view(|view| MapTechnique::<Midpoint>::default().recipe(view)).expect("supported");
        let nudge = Nudge {
            behind: -NUDGE_SECOND,
            ..NO_NUDGE
        };
        let nudged = nudge.recipe(&recipe, 0.0);
        let mut peeled = 0;
        for (cast, before) in nudged.casts.iter().zip(&recipe.casts) {
            let has_moved = cast.space != before.space;
            assert_eq!(has_moved, is_behind(cast));
            peeled += usize::from(has_moved);
        }
        assert!(peeled > 0 && peeled < recipe.casts.len());
    }

    /// Compares with transforms in 64 bits.
    #[test]
    fn lookups_are_rounded_by_less_than_the_bound() {
        let recipe =
            with_view(|view| MapTechnique::<Hard>::default().recipe(view)).expect("supported");
        let space = recipe.casts[0].space;
        let m = space.clip_from_world();
        for i in 0..1000 {
            let at = |n: f32| 1e4 * (i as f32 * n).sin();
            let p = Vec3::new(at(0.7), at(1.3), at(2.9));
            let bound = lookup_rounding(&space, p.abs().max_element());
            let exact = m.as_dmat4() * p.as_dvec3().extend(1.0);
            let error = (m * p.extend(1.0)).as_dvec4() - exact;
            assert!(error.truncate().abs().cmple(bound.as_dvec3()).all(), "{p}");
        }
        let lamp = umbrage_core::light_space::perspective(1.0, 1.0, 0.1, 9.0).expect("valid");
        let lamp = LightSpace {
            clip_from_view: lamp,
            ..space
        };
        assert_eq!(lookup_rounding(&lamp, 1e4), Vec3::ZERO);
    }

    #[test]
    fn all_normals_turn_alike() {
        let receivers = with_view(|view| {
            Cpu::new()
                .receivers(view.camera, view.geometry.expect("given"))
                .expect("valid")
        });
        let by = Vec3::new(0.5, 0.0, -0.25);
        let turned = turn_receivers(receivers.clone(), by);
        for i in 0..receivers.len() {
            assert_eq!(turned.normal(i), receivers.normal(i) + by);
        }
    }
}
