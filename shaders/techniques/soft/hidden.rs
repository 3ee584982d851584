//! Part of a light that a triangle hides from one point: linear functions over the light's plane,
//! evaluated for whole rows of points.
//!
//! Let a, b, c be the corners relative to the receiver. The ray along d passes the triangle if d is
//! on the same side of the three planes through the receiver and an edge. That is,
//! `(a x (b - a)) . d` and so on have the sign of the volume `a . ((b - a) x (c - a))` (Möller and
//! Trumbore 1997, "Fast, Minimum Storage Ray/Triangle Intersection", in homogeneous form). The rays
//! to a light's points are linear in two coordinates ([`LightPlane`]), and so are these functions.
//! The test whether the triangle's plane is before the light is linear, too.
//!
//! - If a function is negative all over the light, the triangle hides nothing, and no sample is
//!   needed.
//! - Otherwise each function changes its sign at one position of a row, and a row's hidden points
//!   are a run of bits (Kalbertodt's bit masks, 2023, one row at a time). Eisemann and Décoret
//!   2007, "Visibility Sampling on GPU and Applications", also sample light sources by bit masks of
//!   edges.
//!
//! **No gaps.** All triangles use the same order of corners ([`sort_corners`]). So neighbours have
//! the same function for their common edge, except for its sign, to the last bit. Where it is 0,
//! both hide the point. **No distance amplification.** An edge's function uses the edge's own
//! vector, whose error is proportional to its length. So functions of small or distant triangles
//! have an error of a few roundings of the distance, not of its inverse.

use super::{
    lattice::{Lattice, MAX_ROWS},
    light_plane::LightPlane,
};
use umbrage_core::{
    Module,
    glam::{Vec2, Vec3},
    math::{cross3, dot3, greater, lesser},
    module,
};

/// The WGSL half.
pub(super) const HIDDEN: Module = module!("soft_hidden", "hidden.wgsl");

/// Returns a triangle's corners in an order that depends only on their coordinates.
#[inline(always)]
pub(super) fn sort_corners(corners: [Vec3; 3]) -> [Vec3; 3] {
    let [a, b, c] = corners;
    let [a, b] = in_order(a, b);
    let [b, c] = in_order(b, c);
    let [a, b] = in_order(a, b);
    [a, b, c]
}

#[inline(always)]
fn in_order(a: Vec3, b: Vec3) -> [Vec3; 2] {
    let is_before = a.x < b.x || a.x == b.x && (a.y < b.y || a.y == b.y && a.z <= b.z);
    if is_before { [a, b] } else { [b, a] }
}

/// Triangle: two of its corners, the vectors of its edges, and its normal vector.
#[derive(Clone, Copy, Debug)]
pub(super) struct Caster {
    a: Vec3,
    b: Vec3,
    a_to_b: Vec3,
    b_to_c: Vec3,
    a_to_c: Vec3,
    across: Vec3,
}

impl Caster {
    #[inline(always)]
    pub(super) fn new(corners: [Vec3; 3]) -> Self {
        let [a, b, c] = sort_corners(corners);
        let a_to_b = b - a;
        let a_to_c = c - a;
        Self {
            a,
            b,
            a_to_b,
            b_to_c: c - b,
            a_to_c,
            across: cross3(a_to_b, a_to_c),
        }
    }
}

/// Number of receivers that process a triangle together.
pub(super) const LANES: usize = 8;

/// One value per receiver.
pub(super) type Numbers = [f32; LANES];

/// One vector per receiver.
pub(super) type Vectors = [Numbers; 3];

/// Returns the vector of one receiver.
#[inline(always)]
fn vector_of(vectors: &Vectors, lane: usize) -> Vec3 {
    Vec3::new(vectors[0][lane], vectors[1][lane], vectors[2][lane])
}

/// Receivers, and the light relative to each of them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seers {
    origin: Vectors,
    normal: Vectors,
    center: Vectors,
    u: Vectors,
    v: Vectors,
}

impl Seers {
    /// No receivers.
    pub(super) const NONE: Self = {
        const ZERO: Vectors = [[0.0; LANES]; 3];
        Self {
            origin: ZERO,
            normal: ZERO,
            center: ZERO,
            u: ZERO,
            v: ZERO,
        }
    };

    /// Returns the ray of a receiver to a point of its light: its origin and its vector.
    #[inline(always)]
    pub(super) fn ray(&self, lane: usize, point: Vec2) -> [Vec3; 2] {
        let center = vector_of(&self.center, lane);
        let u = vector_of(&self.u, lane);
        let v = vector_of(&self.v, lane);
        [
            vector_of(&self.origin, lane),
            center + u * point.x + v * point.y,
        ]
    }

    /// Sets receiver `lane` to the one at `o` on a surface with normal `n`.
    #[inline(always)]
    pub(super) fn set(&mut self, lane: usize, o: Vec3, n: Vec3, plane: &LightPlane) {
        for axis in 0..3 {
            self.origin[axis][lane] = o[axis];
            self.normal[axis][lane] = n[axis];
            self.center[axis][lane] = plane.center[axis];
            self.u[axis][lane] = plane.u[axis];
            self.v[axis][lane] = plane.v[axis];
        }
    }
}

/// Linear function over the light's plane, one per receiver. Points may be hidden where it is not
/// negative.
#[derive(Clone, Copy, Debug)]
pub(super) struct Functions {
    middle: Numbers,
    along_u: Numbers,
    along_v: Numbers,
}

impl Functions {
    const ZERO: Self = Self {
        middle: [0.0; LANES],
        along_u: [0.0; LANES],
        along_v: [0.0; LANES],
    };

    /// Sets the function of receiver `lane` to the vectors' components along `normal`.
    #[inline(always)]
    fn set(&mut self, lane: usize, normal: Vec3, seers: &Seers) {
        self.middle[lane] = dot3(normal, vector_of(&seers.center, lane));
        self.along_u[lane] = dot3(normal, vector_of(&seers.u, lane));
        self.along_v[lane] = dot3(normal, vector_of(&seers.v, lane));
    }

    /// Returns the greatest difference of the function from its value at the centre, over -1 to 1
    /// in both coordinates.
    #[inline(always)]
    fn reach(&self, lane: usize) -> f32 {
        self.along_u[lane].abs() + self.along_v[lane].abs()
    }
}

/// Least absolute growth along a row; smaller values are replaced by it.
const LEAST_GROWTH: f32 = 1e-30;

/// Function of each receiver, and its growth along rows.
#[derive(Clone, Copy, Debug)]
struct Cuts {
    functions: Functions,
    /// One over the growth from point to point.
    inverse: Numbers,
}

impl Cuts {
    #[inline(always)]
    fn new(functions: &Functions, step: Vec2) -> Self {
        let functions = *functions;
        let mut inverse = [0.0; LANES];
        for (i, inverse) in inverse.iter_mut().enumerate() {
            let growth = functions.along_u[i] * step.x + functions.along_v[i] * step.y;
            let is_level = growth.abs() < LEAST_GROWTH;
            *inverse = 1.0 / if is_level { LEAST_GROWTH } else { growth };
        }
        Self { functions, inverse }
    }

    /// Narrows a row's runs of positions, from `since` to `until`, to where the functions are not
    /// negative. `first` is the row's first point.
    #[inline(always)]
    fn cut(&self, first: Vec2, since: &mut Numbers, until: &mut Numbers) {
        let f = &self.functions;
        for i in 0..LANES {
            let at_first = f.middle[i] + f.along_u[i] * first.x + f.along_v[i] * first.y;
            let root = -at_first * self.inverse[i];
            let rises = self.inverse[i] > 0.0;
            since[i] = greater(since[i], if rises { root } else { 0.0 });
            until[i] = lesser(until[i], if rises { ALL_PLACES } else { root });
        }
    }
}

/// Position behind the last one of a row.
const ALL_PLACES: f32 = MAX_ROWS as f32;

/// Words of bits, one per receiver.
pub(super) type Words = [u32; LANES];

/// All bits.
pub(super) const ALL: u32 = u32::MAX;

/// Points of each receiver's light that are not hidden, row by row.
pub(super) type Open = [Words; MAX_ROWS];

/// Hides the points below the receivers' own planes.
#[inline(always)]
pub(super) fn close_below_horizon(seers: &Seers, lattice: &Lattice, rows: usize, open: &mut Open) {
    let mut heights = Functions::ZERO;
    for i in 0..LANES {
        heights.set(i, vector_of(&seers.normal, i), seers);
    }
    let cuts = Cuts::new(&heights, lattice.step);
    for (row, open) in open[..rows].iter_mut().enumerate() {
        let mut since = [0.0; LANES];
        let mut until = [ALL_PLACES; LANES];
        cuts.cut(lattice.first_of(row), &mut since, &mut until);
        for i in 0..LANES {
            // If all heights are level, the light is in the plane.
            let is_up = heights.middle[i] + heights.reach(i) > 0.0;
            open[i] &= if is_up {
                run_of_bits(since[i], until[i])
            } else {
                0
            };
        }
    }
}

/// Part of each receiver's light that a triangle hides.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shade {
    cuts: [Cuts; FUNCTIONS],
    /// All bits for receivers with a light that the triangle may hide partly, else none.
    may_hide: Words,
}

/// Number of functions per triangle: its edges, and its plane.
const FUNCTIONS: usize = 4;

impl Shade {
    /// Shade of no triangle.
    pub(super) const NONE: Self = Self {
        cuts: [Cuts {
            functions: Functions::ZERO,
            inverse: [0.0; LANES],
        }; FUNCTIONS],
        may_hide: [0; LANES],
    };

    /// Finds the functions of a triangle. Returns whether it may hide something from the receivers
    /// that are `queried` (all bits set). `LAMP`: the light has a position.
    #[inline(always)]
    pub(super) fn find<const LAMP: bool>(
        &mut self,
        caster: &Caster,
        seers: &Seers,
        queried: &Words,
        step: Vec2,
    ) -> bool {
        let mut functions = [Functions::ZERO; FUNCTIONS];
        let mut may_hide = [0; LANES];
        let mut any = 0;
        // Set the functions of each receiver.
        for i in 0..LANES {
            let o = vector_of(&seers.origin, i);
            let a = caster.a - o;
            let b = caster.b - o;
            let volume = dot3(caster.across, a);
            let sign = if volume < 0.0 { -1.0 } else { 1.0 };
            let [ab, bc, ac, before] = &mut functions;
            ab.set(i, cross3(a, caster.a_to_b) * sign, seers);
            bc.set(i, cross3(b, caster.b_to_c) * sign, seers);
            ac.set(i, cross3(a, caster.a_to_c) * -sign, seers);
            let greatest = |f: &Functions| f.middle[i] + f.reach(i);
            // A triangle viewed edge-on hides nothing.
            let mut least = if volume == 0.0 { -1.0 } else { 0.0 };
            least = lesser(least, greatest(ab));
            least = lesser(least, greatest(bc));
            least = lesser(least, greatest(ac));
            if LAMP {
                // Test whether the triangle's plane is before the light.
                before.set(i, caster.across * sign, seers);
                before.middle[i] -= volume * sign;
                least = lesser(least, greatest(before));
            }
            may_hide[i] = if least >= 0.0 { queried[i] } else { 0 };
            any |= may_hide[i];
        }
        if any == 0 {
            return false;
        }
        // Prepare the functions for rows of points.
        self.may_hide = may_hide;
        let count = if LAMP { FUNCTIONS } else { FUNCTIONS - 1 };
        for (cuts, functions) in self.cuts[..count].iter_mut().zip(&functions) {
            *cuts = Cuts::new(functions, step);
        }
        true
    }

    /// Hides the points of a row that the triangle covers. `first` is the row's first point.
    #[inline(always)]
    pub(super) fn close<const LAMP: bool>(&self, first: Vec2, open: &mut Words) {
        let covered = self.covered_samples::<LAMP>(first);
        for (open, covered) in open.iter_mut().zip(covered) {
            *open &= !covered;
        }
    }

    /// Returns the points of a row that the triangle covers.
    #[inline(always)]
    pub(super) fn covered_samples<const LAMP: bool>(&self, first: Vec2) -> Words {
        let mut since = [0.0; LANES];
        let mut until = [ALL_PLACES; LANES];
        let functions = if LAMP { FUNCTIONS } else { FUNCTIONS - 1 };
        for cuts in &self.cuts[..functions] {
            cuts.cut(first, &mut since, &mut until);
        }
        let mut covered = [0; LANES];
        for i in 0..LANES {
            covered[i] = run_of_bits(since[i], until[i]) & self.may_hide[i];
        }
        covered
    }
}

/// Returns the bits of the integer positions from `since`, at least 0, to `until`, at most
/// [`MAX_ROWS`].
#[inline(always)]
fn run_of_bits(since: f32, until: f32) -> u32 {
    let first = whole(lesser(since.ceil(), ALL_PLACES));
    let after = whole(lesser(greater(until.floor() + 1.0, 0.0), ALL_PLACES));
    1_u32.wrapping_shl(after).wrapping_sub(1) & !1_u32.wrapping_shl(first).wrapping_sub(1)
}

/// Converts a non-negative integer value to an integer. Adding 2^23 moves it into the lowest bits,
/// a conversion without range checks.
#[inline(always)]
fn whole(x: f32) -> u32 {
    const WHOLE: f32 = 8_388_608.0;
    const WHOLE_BITS: u32 = (1 << 23) - 1;
    (x + WHOLE).to_bits() & WHOLE_BITS
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::techniques::soft::lattice::{Domain, Lattices};

    /// Returns a deterministic number from -1 to 1.
    fn noise(state: &mut u32) -> f32 {
        *state = umbrage_core::light_sample::hash(*state);
        *state as f32 / 2_147_483_648.0 - 1.0
    }

    fn vector(state: &mut u32) -> Vec3 {
        Vec3::new(noise(state), noise(state), noise(state))
    }

    #[test]
    fn runs_of_bits_are_those_of_whole_places() {
        for (since, until, bits) in [
            (0.0, 31.0, 0x7fff_ffff),
            (0.0, -0.5, 0),
            (0.5, 2.5, 0b110),
            (1.0, 1.0, 0b10),
            (2.1, 2.9, 0),
            (30.0, 30.2, 1 << 30),
            (1e30, 31.0, 0),
            (0.0, -1e30, 0),
        ] {
            assert_eq!(run_of_bits(since, until), bits, "{since} to {until}");
        }
    }

    /// Returns the open points of each receiver behind some triangles, row by row.
    fn open_behind<const LAMP: bool>(
        triangles: &[[Vec3; 3]],
        seers: &Seers,
        lattice: &Lattice,
    ) -> [[u32; MAX_ROWS]; LANES] {
        let mut open: Open = std::array::from_fn(|row| [lattice.bits[row]; LANES]);
        for &corners in triangles {
            let caster = Caster::new(corners);
            let mut shade = Shade::NONE;
            if shade.find::<LAMP>(&caster, seers, &[ALL; LANES], lattice.step) {
                for (row, open) in open.iter_mut().enumerate() {
                    shade.close::<LAMP>(lattice.first_of(row), open);
                }
            }
        }
        std::array::from_fn(|lane| std::array::from_fn(|row| open[row][lane]))
    }

    /// Compares with double-precision tests of each point, except near the edges of triangles. A
    /// light with a position is not hidden by casters behind it.
    #[test]
    fn bits_are_those_of_single_rays() {
        let lattices = Lattices::new(Domain::Square, 15);
        let mut state = 5;
        let mut seen = [0; 2];
        for number in 0..4000 {
            let lattice = lattices.of_noise(number);
            let plane = LightPlane {
                center: Vec3::new(0.0, 0.0, 4.0) + vector(&mut state),
                u: vector(&mut state),
                v: vector(&mut state),
            };
            let o = vector(&mut state) * 10.0;
            let shift = Vec3::new(0.0, 0.0, 3.0);
            let corners = [0; 3].map(|_| o + shift + vector(&mut state) * 2.0);
            let mut seers = Seers::NONE;
            seers.set(3, o, plane.center, &plane);
            let open = open_behind::<true>(&[corners], &seers, lattice)[3];
            for (row, open) in open.iter().enumerate().take(15) {
                for place in 0..15 {
                    let uv = lattice.first_of(row) + lattice.step * place as f32;
                    let d = plane.center + plane.u * uv.x + plane.v * uv.y;
                    let Some(is_hit) = hits(o, d, corners) else {
                        continue;
                    };
                    let is_open = open >> place & 1 == 1;
                    assert_eq!(is_open, !is_hit, "{number}: row {row}, place {place}");
                    seen[usize::from(is_hit)] += 1;
                }
            }
        }
        assert!(seen.iter().all(|&count| count > 50_000), "{seen:?}");
    }

    /// Returns whether a segment hits a triangle, in double precision; `None` near its edges.
    fn hits(o: Vec3, d: Vec3, corners: [Vec3; 3]) -> Option<bool> {
        let [a, b, c] = corners.map(|p| (p - o).as_dvec3());
        let d = d.as_dvec3();
        let across = (b - a).cross(c - a);
        let volume = across.dot(a);
        let weights = [b.cross(c).dot(d), c.cross(a).dot(d), a.cross(b).dot(d)].map(|w| w / volume);
        let along = across.dot(d) / volume;
        let slack = [weights[0], weights[1], weights[2], along - 1.0];
        if slack.iter().any(|s| s.abs() < 1e-3) {
            return None;
        }
        Some(slack.iter().all(|&s| s > 0.0))
    }

    /// Two triangles with a common edge leave no open point on it. The result does not depend on
    /// their order.
    #[test]
    fn neighbours_leave_no_gap() {
        let lattices = Lattices::new(Domain::Disc, 31);
        let mut state = 11;
        for number in 0..3000 {
            let lattice = lattices.of_noise(number);
            let scale = [1e-3, 1.0, 1e3][number as usize % 3];
            let o = vector(&mut state) * scale;
            let plane = LightPlane {
                center: Vec3::new(0.1, 0.2, 1.0),
                u: Vec3::new(0.1, 0.0, -0.01),
                v: Vec3::new(0.0, 0.1, -0.02),
            };
            // Build a quadrilateral that hides the whole light, split by an edge through its
            // centre.
            let middle = o + plane.center * scale * (2.0 + noise(&mut state));
            let side = vector(&mut state).cross(plane.center).normalize() * scale;
            let other = side.cross(plane.center).normalize() * scale;
            let [p, q] = [middle + side * 9.0, middle - side * 9.0];
            let [r, s] = [middle + other * 9.0, middle - other * 9.0];
            let mut seers = Seers::NONE;
            seers.set(0, o, plane.center, &plane);
            let open = open_behind::<false>(&[[p, q, r], [s, q, p]], &seers, lattice)[0];
            assert_eq!(open, [0; MAX_ROWS], "{number}");
        }
    }
}
