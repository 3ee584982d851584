//! Projection of boxes and triangles onto the lattice for a group of neighbours: bounds of rows and
//! of positions in them.
//!
//! Let P and Q be the steps from point to point and from row to row, and C the vector to the
//! light's centre. The vector d leads to the point `C + P x + Q y` of the light's plane for
//! `x = d.(Q x C) / w`, `y = d.(C x P) / w`, `w = d.(P x Q)` (Cramer's rule). Bounds of the three
//! products over a box bound x and y. For other receivers, up to `reach` away from the central one,
//! d differs by as much. The distance to a light with a position also differs, which `slack`
//! covers. Bounds are conservative. Their margin is far more than the rounding errors here and in
//! the functions of `hidden.rs`.

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

/// Margin, as a fraction of the distance between points.
const MARGIN: f32 = 0.01;

/// Additional margin, as a fraction of the light's distance (2^-17).
const DISTANCE_MARGIN: f32 = 1.0 / 131_072.0;

/// Greatest relative difference of distances to a light with a position for which bounds are
/// computed.
const MOST_SLACK: f32 = 0.25;

/// Projection of boxes onto a lattice.
#[derive(Clone, Copy, Debug)]
pub(super) struct Footprint {
    /// Central receiver, and the greatest distance of the others along each axis.
    origin: Vec3,
    reach: Vec3,
    /// Products `Q x C`, `C x P`, `P x Q`.
    factors: [Vec3; 3],
    /// Position and row of the light's centre.
    middle: Vec2,
    /// Margin in points and rows.
    margin: Vec2,
    /// Minimum and maximum factor of w.
    slack: [f32; 2],
    /// True if any bounds are valid.
    is_bounded: bool,
    last_row: f32,
}

/// Bounds of positions and rows, for four things at once.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    places: [Vec4; 2],
    rows: [Vec4; 2],
    /// Bits of the things that are unbounded.
    pub(super) anywhere: u32,
}

impl Footprint {
    /// Footprint without receivers, which bounds nothing.
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

    /// Returns the footprint for the receiver at `origin`, whose light plane is `plane`. The other
    /// receivers are up to `reach` away. Their lights' points, relative to it, are up to `shift`
    /// from its own.
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
        // Account for shifted rows: they begin up to one point later, and their points are deeper
        // by the same amount than along the rows.
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
            // A light that is edge-on or without extent bounds nothing. The comparison is false for
            // NaN.
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

    /// Returns bounds of points with a tolerance of `reach`.
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

    /// Returns the rows of one of the bounded things, and the bits of its positions in them.
    #[inline(always)]
    pub(super) fn part(&self, bounds: &Bounds, which: usize) -> Part {
        if bounds.anywhere >> which & 1 == 1 {
            return Part {
                rows: 0..self.last_row as usize + 1,
                places: u32::MAX,
            };
        }
        self.part_between(
            [bounds.places[0][which], bounds.places[1][which]],
            [bounds.rows[0][which], bounds.rows[1][which]],
        )
    }

    /// Returns the rows of the convex hull of the first three bounded things.
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
        self.part_between(around(&bounds.places), around(&bounds.rows))
    }

    #[inline(always)]
    fn part_between(&self, places: [f32; 2], rows: [f32; 2]) -> Part {
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

/// Range of rows of a lattice, and bits of the same positions in each.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Part {
    pub(super) rows: Range<usize>,
    pub(super) places: u32,
}

#[inline(always)]
fn length(v: Vec3) -> f32 {
    dot3(v, v).sqrt()
}
