//! Where on the lattice boxes and triangles show, as seen from some neighbours together: bounds of
//! rows and of places in them.
//!
//! With P and Q from point to point and from row to row, and C towards the light's middle, the
//! vector d leads to the point `C + P x + Q y` of the light's plane for `x = d.(Q x C) / w`,
//! `y = d.(C x P) / w`, `w = d.(P x Q)` (Cramer's rule). Bounds of the three products over a box
//! bound x and y. From other receivers, up to `reach` away from the one in the middle, d differs by
//! as much; and to a lamp the way differs in length, which `slack` allows for. Cautious: what shows
//! lies within the bounds, by a margin that is far more than what is rounded, here and in the
//! functions of `hidden.rs`.

use super::{
    lattice::{Lattice, Lattices, MAX_ROWS},
    light_plane::LightPlane,
};
use std::ops::Range;
use umbrage_core::{
    Module,
    glam::{Mat2, Vec2, Vec3, Vec4, Vec4Swizzles as _},
    math::{cross3, dot3},
    module,
};

/// The WGSL half.
pub(super) const FOOTPRINT: Module = module!("soft_footprint", "footprint.wgsl");

/// Wider by this part of a point's distance from the next.
const MARGIN: f32 = 0.01;

/// And by this part of the light's distance (2^-17).
const DISTANCE_MARGIN: f32 = 1.0 / 131_072.0;

/// Where the way to a lamp differs by more than this part, nothing is bounded.
const MOST_SLACK: f32 = 0.25;

/// How boxes are projected onto a lattice.
#[derive(Clone, Copy, Debug)]
pub(super) struct Footprint {
    /// The receiver in the middle, and how far the others are away along each axis.
    origin: Vec3,
    reach: Vec3,
    /// `Q x C`, `C x P`, `P x Q`.
    factors: [Vec3; 3],
    /// Place and row of the light's middle.
    middle: Vec2,
    /// In points and rows.
    margin: Vec2,
    /// What w is multiplied with, at least and at most.
    slack: [f32; 2],
    /// Whether anything can be bounded.
    is_bounded: bool,
    last_row: f32,
}

/// Bounds of places and rows, of four things at once.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    places: [Vec4; 2],
    rows: [Vec4; 2],
    /// A bit for each that may show anywhere.
    pub(super) anywhere: u32,
}

impl Footprint {
    /// That of nobody: it bounds nothing.
    pub(super) const NOTHING: Self = Self {
        origin: Vec3::ZERO,
        reach: Vec3::ZERO,
        factors: [Vec3::ZERO; 3],
        middle: Vec2::ZERO,
        margin: Vec2::ZERO,
        slack: [1.0; 2],
        is_bounded: false,
        last_row: 0.0,
    };

    /// `plane` is that of the receiver at `origin`; the others are up to `reach` away, and their
    /// lights' points, seen from it, up to `shift` from its own.
    #[inline(always)]
    pub(super) fn new<const LAMP: bool>(
        origin: Vec3,
        reach: Vec3,
        shift: f32,
        plane: &LightPlane,
        lattices: &Lattices,
        lattice: &Lattice,
    ) -> Self {
        let p = plane.u * lattice.step.x + plane.v * lattice.step.y;
        let q = plane.u * lattice.rise.x + plane.v * lattice.rise.y;
        let c = plane.center;
        let factors = [cross3(q, c), cross3(c, p), cross3(p, q)];
        let volume = dot3(factors[2], c);
        let sign = if volume < 0.0 { -1.0 } else { 1.0 };
        let factors = factors.map(|f| f * sign);
        let volume = volume.abs();
        let sizes = Vec2::new(length(factors[0]), length(factors[1])) / volume;
        let from_distance = sizes * (length(c) * DISTANCE_MARGIN + shift);
        let slack = if LAMP {
            2.0 * dot3(reach, factors[2].abs()) / volume
        } else {
            0.0
        };
        // Rows that are shifted begin up to one point later, and so much lie points deeper than
        // along their rows.
        let row_shift = Vec2::new(lattices.shift, lattices.shift / lattices.rows as f32);
        let cell = Mat2::from_cols(lattice.step, lattice.rise);
        let middle = -(cell.inverse() * lattice.origin);
        let largest = sizes.max_element() * length(c);
        Self {
            origin,
            reach,
            factors,
            middle,
            margin: from_distance + MARGIN + row_shift,
            slack: [1.0 - slack, 1.0 + slack],
            // Seen from the side, or of no extent, it bounds nothing; the comparison is false of
            // what is not a number.
            is_bounded: slack < MOST_SLACK && largest < 1e6,
            last_row: (lattices.rows - 1) as f32,
        }
    }

    /// Returns bounds of four boxes; `low` and `high` are their sides along x, y, z.
    #[inline(always)]
    pub(super) fn of_boxes(&self, low: [Vec4; 3], high: [Vec4; 3]) -> Bounds {
        let center = |axis: usize| (low[axis] + high[axis]) * 0.5 - self.origin[axis];
        let half = |axis: usize| (high[axis] - low[axis]) * 0.5 + self.reach[axis];
        let centers = [center(0), center(1), center(2)];
        let halves = [half(0), half(1), half(2)];
        let products = self.factors.map(|f| {
            let size = f.abs();
            let middle = centers[0] * f.x + centers[1] * f.y + centers[2] * f.z;
            let reach = halves[0] * size.x + halves[1] * size.y + halves[2] * size.z;
            [middle - reach, middle + reach]
        });
        self.bounds(products)
    }

    /// Returns bounds of points, each of which may lie `reach` aside.
    #[inline(always)]
    pub(super) fn of_points(&self, x: Vec4, y: Vec4, z: Vec4) -> Bounds {
        let [x, y, z] = [x - self.origin.x, y - self.origin.y, z - self.origin.z];
        let products = self.factors.map(|f| {
            let middle = x * f.x + y * f.y + z * f.z;
            let reach = dot3(f.abs(), self.reach);
            [middle - reach, middle + reach]
        });
        self.bounds(products)
    }

    #[inline(always)]
    fn bounds(&self, products: [[Vec4; 2]; 3]) -> Bounds {
        let [x, y, w] = products;
        let least = w[0] * self.slack[0];
        let greatest = w[1] * self.slack[1];
        let [one_over_least, one_over_greatest] = [least.recip(), greatest.recip()];
        let over = |range: [Vec4; 2], middle: f32, margin: f32| {
            let low = (range[0] * one_over_least).min(range[0] * one_over_greatest);
            let high = (range[1] * one_over_least).max(range[1] * one_over_greatest);
            [low + (middle - margin), high + (middle + margin)]
        };
        let anywhere = if self.is_bounded {
            !least.cmpgt(Vec4::ZERO).bitmask() & 0xf
        } else {
            0xf
        };
        Bounds {
            places: over(x, self.middle.x, self.margin.x),
            rows: over(y, self.middle.y, self.margin.y),
            anywhere,
        }
    }

    /// Returns the rows of one of the things that were bounded, and the bits of its places in them.
    #[inline(always)]
    pub(super) fn part(&self, bounds: &Bounds, which: usize) -> Part {
        if bounds.anywhere >> which & 1 == 1 {
            return Part {
                rows: 0..self.last_row as usize + 1,
                places: u32::MAX,
            };
        }
        self.between(
            [bounds.places[0][which], bounds.places[1][which]],
            [bounds.rows[0][which], bounds.rows[1][which]],
        )
    }

    /// Returns the rows of the first three things that were bounded, and of all that lies between
    /// them.
    #[inline(always)]
    pub(super) fn part_of_three(&self, bounds: &Bounds) -> Part {
        if bounds.anywhere & 0b111 != 0 {
            return Part {
                rows: 0..self.last_row as usize + 1,
                places: u32::MAX,
            };
        }
        let around =
            |range: &[Vec4; 2]| [range[0].xyz().min_element(), range[1].xyz().max_element()];
        self.between(around(&bounds.places), around(&bounds.rows))
    }

    #[inline(always)]
    fn between(&self, places: [f32; 2], rows: [f32; 2]) -> Part {
        let last_place = (MAX_ROWS - 1) as f32;
        let first = rows[0].ceil().max(0.0);
        let last = rows[1].floor().min(self.last_row);
        let begin = places[0].ceil().max(0.0);
        let end = places[1].floor().min(last_place);
        if !(first <= last && begin <= end) {
            return Part {
                rows: 0..0,
                places: 0,
            };
        }
        let bits_to_end = (2_u32 << end as u32).wrapping_sub(1);
        let bits_before = (1_u32 << begin as u32) - 1;
        Part {
            rows: first as usize..last as usize + 1,
            places: bits_to_end & !bits_before,
        }
    }
}

/// Some rows of a lattice, and bits of the same places in each.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Part {
    pub(super) rows: Range<usize>,
    pub(super) places: u32,
}

#[inline(always)]
fn length(v: Vec3) -> f32 {
    dot3(v, v).sqrt()
}
