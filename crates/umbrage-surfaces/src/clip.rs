//! The lit part of a facet: its triangle across the light, minus those of the facets above it.
//!
//! A caster darkens the intersection of up to four half-planes: its three sides, and the line at
//! which it crosses the receiver's plane. The receiver is cut by one caster after another. The
//! parts outside are kept, so that all pieces stay convex.
//!
//! A pair of facets uses the same bits in both roles where it matters: which of the two is above,
//! and where they cross. Each point across the light is therefore lit on one facet only, and the
//! lit areas add up to that of the silhouette.

use crate::{
    grid::Rectangle,
    tree::{self, Limits, Projected},
};
use glam::{DVec2, DVec3, Vec3Swizzles as _};
use std::cell::Cell;

/// Pieces are cut one caster after another up to this number of casters. With more, the polygon is
/// halved first, so that each half has fewer.
const CASTERS_AT_ONCE: usize = 12;

/// Points on the inner side have positive values of `normal.dot(p) + offset`.
#[derive(Clone, Copy, Debug, Default)]
struct HalfPlane {
    normal: DVec2,
    offset: f64,
    /// Values up to this size are roundings of 0.
    slack: f64,
}

impl HalfPlane {
    /// Returns the side to the left of `a` to `b`, for points within `reach` of the origin.
    #[inline(always)]
    fn left_of(a: DVec2, b: DVec2, reach: f64) -> Self {
        let normal = DVec2::new(a.y - b.y, b.x - a.x);
        Self {
            normal,
            offset: -normal.dot(a),
            slack: slack(normal, reach),
        }
    }

    #[inline(always)]
    fn value(&self, p: DVec2) -> f64 {
        self.normal.x * p.x + self.normal.y * p.y + self.offset
    }

    /// Returns the least and the greatest value at some points.
    #[inline(always)]
    fn range(&self, points: &[DVec2]) -> [f64; 2] {
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        for &p in points {
            let value = self.value(p);
            range = [range[0].min(value), range[1].max(value)];
        }
        range
    }
}

/// Returns a bound of the rounding of a half-plane's value at points within `reach` of the origin:
/// three roundings of products of that size.
#[inline(always)]
fn slack(normal: DVec2, reach: f64) -> f64 {
    (normal.x.abs() + normal.y.abs()) * reach * (4.0 * f64::EPSILON)
}

/// The half-planes whose intersection a caster darkens, without those that contain the receiver.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Blocker {
    planes: [HalfPlane; 4],
    count: usize,
}

impl Blocker {
    fn planes(&self) -> &[HalfPlane] {
        &self.planes[..self.count]
    }

    /// Returns the part of the blocker within a convex polygon; `None` if they don't overlap.
    pub(crate) fn within(&self, polygon: &[DVec2]) -> Option<Self> {
        let mut part = Self::default();
        for plane in self.planes() {
            let [least, most] = plane.range(polygon);
            if most <= plane.slack {
                return None;
            }
            if least < -plane.slack {
                part.push(*plane);
            }
        }
        Some(part)
    }

    fn push(&mut self, plane: HalfPlane) {
        self.planes[self.count] = plane;
        self.count += 1;
    }

    /// Returns whether the whole receiver is dark.
    pub(crate) fn covers_all(&self) -> bool {
        self.count == 0
    }
}

/// A facet whose lit part is computed.
pub(crate) struct Receiver<'a> {
    facet: &'a Projected,
    row: u32,
    twice_area: f64,
    /// The origin of all coordinates: a corner.
    origin: DVec2,
    pub(crate) corners: [DVec2; 3],
    /// Sides of the receiver, inner to the left.
    sides: [HalfPlane; 3],
    size: f64,
    margin: f64,
    /// True if a facet was found that is in the same plane and overlaps.
    pub(crate) has_coplanar: Cell<bool>,
}

impl<'a> Receiver<'a> {
    pub(crate) fn new(facet: &'a Projected, row: u32, margin: f64) -> Self {
        let origin = facet.corners[0].xy();
        let corners = facet.corners.map(|c| c.xy() - origin);
        let [a, b, c] = corners;
        let size = (b.abs().max(c.abs())).max_element();
        Self {
            facet,
            row,
            twice_area: facet.twice_area(),
            origin,
            corners,
            // The slack depends on the caster: see `blocker`.
            sides: [(a, b), (b, c), (c, a)].map(|(a, b)| HalfPlane::left_of(a, b, 1.0)),
            size,
            margin,
            has_coplanar: Cell::new(false),
        }
    }

    /// Returns the part of the receiver within a rectangle of the frame.
    pub(crate) fn part_within(&self, rectangle: Rectangle) -> Vec<DVec2> {
        let [low, high] = rectangle.map(|corner| corner - self.origin);
        let sides = [
            (DVec2::X, -low.x),
            (DVec2::Y, -low.y),
            (DVec2::NEG_X, high.x),
            (DVec2::NEG_Y, high.y),
        ];
        let mut part = self.corners.to_vec();
        for (normal, offset) in sides {
            let slack = 0.0;
            let plane = HalfPlane {
                normal,
                offset,
                slack,
            };
            [part, _] = split(&part, &plane);
        }
        part
    }

    /// Returns a query for facets that may darken a part of the receiver.
    pub(crate) fn query_above(&self, polygon: &[DVec2]) -> Limits {
        let in_frame = polygon
            .iter()
            .map(|&point| (point + self.origin).extend(self.facet.height_at(point)));
        tree::query_above(in_frame, self.margin)
    }

    /// Returns what a caster darkens; `None` if that is nothing.
    pub(crate) fn blocker(&self, caster: &Projected, row: u32) -> Option<Blocker> {
        let corners = caster.corners.map(|c| c.xy() - self.origin);
        let [a, b, c] = corners;
        let far = a.abs().max(b.abs()).max(c.abs()).max_element();
        let reach = 2.0 * (far + self.size);
        // Separating axes: sides of the receiver.
        for side in &self.sides {
            if side.range(&corners)[1] <= side.slack * reach {
                return None;
            }
        }
        // Sides of the caster. Those that contain the receiver cut nothing.
        let mut blocker = Blocker::default();
        for (a, b) in [(a, b), (b, c), (c, a)] {
            let side = HalfPlane::left_of(a, b, reach);
            let [least, most] = side.range(&self.corners);
            if most <= side.slack {
                return None;
            }
            if least < -side.slack {
                blocker.push(side);
            }
        }
        match self.order(caster, row) {
            Order::Below => None,
            Order::Above => Some(blocker),
            Order::Coplanar => {
                self.has_coplanar.set(true);
                (row < self.row).then_some(blocker)
            }
            Order::Crossing { from, to } => {
                let above = HalfPlane::left_of(from - self.origin, to - self.origin, reach);
                let [least, most] = above.range(&self.corners);
                if most <= above.slack {
                    return None;
                }
                if least < -above.slack {
                    blocker.push(above);
                }
                Some(blocker)
            }
        }
    }

    /// Returns where the caster is above the receiver.
    #[inline(always)]
    fn order(&self, caster: &Projected, row: u32) -> Order {
        let caster_area = caster.twice_area();
        // Compare the corners of the smaller facet with the plane of the larger one, so that the
        // plane is extrapolated as little as possible. Both roles compute the same bits.
        let caster_is_small = (caster_area, self.row) < (self.twice_area, row);
        let (small, large) = if caster_is_small {
            (caster, self.facet)
        } else {
            (self.facet, caster)
        };
        let heights = heights_above(small, large, self.margin);
        let least = heights[0].min(heights[1]).min(heights[2]);
        let most = heights[0].max(heights[1]).max(heights[2]);
        match (least < 0.0, most > 0.0) {
            (false, false) => Order::Coplanar,
            (true, false) if caster_is_small => Order::Below,
            (false, true) if !caster_is_small => Order::Below,
            (true, true) => {
                let [from, to] = crossing_line(small, heights);
                if caster_is_small {
                    Order::Crossing { from, to }
                } else {
                    Order::Crossing { from: to, to: from }
                }
            }
            _ => Order::Above,
        }
    }
}

/// Position of a caster relative to the receiver's plane, as the sun sees it.
enum Order {
    Below,
    Above,
    Coplanar,
    /// Above to the left of a line.
    Crossing {
        from: DVec2,
        to: DVec2,
    },
}

/// Returns the points at which a facet crosses a plane, given the heights of its corners above the
/// plane, of both signs. Its part above is to the left of the line from the first to the second.
fn crossing_line(facet: &Projected, heights: [f64; 3]) -> [DVec2; 2] {
    let corners = facet.corners.map(|corner| corner.xy());
    let mut line = [DVec2::ZERO; 2];
    for i in 0..3 {
        let j = (i + 1) % 3;
        let before = heights[(i + 2) % 3];
        // Corners are counter-clockwise: the outline goes below at the first point.
        let [start, end] = [heights[i], heights[j]];
        if start == 0.0 {
            line[usize::from(before < 0.0)] = corners[i];
        } else if start * end < 0.0 {
            let fraction = start / (start - end);
            line[usize::from(start < 0.0)] = corners[i] + (corners[j] - corners[i]) * fraction;
        }
    }
    line
}

/// Returns the heights of a facet's corners above the plane of another one; 0 within the margin of
/// the plane.
#[inline(always)]
fn heights_above(facet: &Projected, plane: &Projected, margin: f64) -> [f64; 3] {
    let [a, b, c] = plane.corners;
    let p = b - a;
    let q = c - a;
    let inverse = 1.0 / p.xy().perp_dot(q.xy());
    let slope_x = (p.z * q.y - p.y * q.z) * inverse;
    let slope_y = (p.x * q.z - p.z * q.x) * inverse;
    // Height of the margin, which is a distance from the plane.
    let slack = margin * (1.0 + slope_x.abs() + slope_y.abs());
    facet.corners.map(|corner| {
        let step = corner - a;
        // Weights of the plane's corners: beyond the facet, they multiply its rounding.
        let weight_b = step.xy().perp_dot(q.xy()) * inverse;
        let weight_c = p.xy().perp_dot(step.xy()) * inverse;
        let sum = weight_b.abs() + weight_c.abs() + (1.0 - weight_b - weight_c).abs();
        let height = step.z - weight_b * p.z - weight_c * q.z;
        if height.abs() <= slack * sum {
            0.0
        } else {
            height
        }
    })
}

/// Returns the moments of a convex polygon: six times the integrals of x and of y, and twice the
/// area.
fn moments(polygon: &[DVec2]) -> DVec3 {
    let mut sum = DVec3::ZERO;
    for pair in polygon.windows(2) {
        let twice_area = (pair[0] - polygon[0]).perp_dot(pair[1] - polygon[0]);
        sum += (polygon[0] + pair[0] + pair[1]).extend(1.0) * twice_area;
    }
    sum
}

/// Returns the moments of the part of a convex polygon that no blocker darkens. It is halved up to
/// `halvings` times while that separates many blockers.
pub(crate) fn lit_moments(polygon: &[DVec2], blockers: &[Blocker], halvings: u32) -> DVec3 {
    if blockers.len() > CASTERS_AT_ONCE && halvings > 0 {
        let halves = halve(polygon);
        let lists = halves.each_ref().map(|half| {
            let parts = blockers.iter().filter_map(|blocker| blocker.within(half));
            parts.collect::<Vec<Blocker>>()
        });
        // Halving isn't worth it if most blockers meet in a point or along a line.
        let parts = lists[0].len() + lists[1].len();
        if 2 * parts < 3 * blockers.len() {
            let lit_half = |half: usize| {
                if lists[half].iter().any(Blocker::covers_all) {
                    return DVec3::ZERO;
                }
                lit_moments(&halves[half], &lists[half], halvings - 1)
            };
            return lit_half(0) + lit_half(1);
        }
    }
    let mut lit = DVec3::ZERO;
    // Pieces, each with the first blocker that it has not been cut by.
    let mut pieces = vec![(polygon.to_vec(), 0)];
    while let Some((piece, first)) = pieces.pop() {
        let mut next = first..blockers.len();
        let overlapping = next.find_map(|i| Some((i, blockers[i].within(&piece)?)));
        let Some((i, part)) = overlapping else {
            lit += moments(&piece);
            continue;
        };
        let mut inner = piece;
        for plane in part.planes() {
            let [inside, outside] = split(&inner, plane);
            if outside.len() > 2 {
                pieces.push((outside, i + 1));
            }
            inner = inside;
        }
    }
    lit
}

/// Returns the halves of a convex polygon, cut across the longer side of its box.
pub(crate) fn halve(polygon: &[DVec2]) -> [Vec<DVec2>; 2] {
    let [low, high] = polygon.iter().fold([polygon[0]; 2], |[low, high], p| {
        [low.min(*p), high.max(*p)]
    });
    let size = high - low;
    let normal = if size.x >= size.y { DVec2::X } else { DVec2::Y };
    let plane = HalfPlane {
        normal,
        offset: -normal.dot(low.midpoint(high)),
        slack: 0.0,
    };
    split(polygon, &plane)
}

/// Returns the inner and the outer part of a convex polygon. Corners within the slack are of both.
fn split(polygon: &[DVec2], plane: &HalfPlane) -> [Vec<DVec2>; 2] {
    let mut inner = Vec::with_capacity(polygon.len() + 1);
    let mut outer = Vec::with_capacity(polygon.len() + 1);
    let value = |p: DVec2| {
        let value = plane.value(p);
        if value.abs() <= plane.slack {
            0.0
        } else {
            value
        }
    };
    let mut from = polygon.last().copied().unwrap_or_default();
    let mut from_value = value(from);
    for &to in polygon {
        let to_value = value(to);
        if from_value * to_value < 0.0 {
            let crossing = from + (to - from) * (from_value / (from_value - to_value));
            inner.push(crossing);
            outer.push(crossing);
        }
        if to_value >= 0.0 {
            inner.push(to);
        }
        if to_value <= 0.0 {
            outer.push(to);
        }
        from = to;
        from_value = to_value;
    }
    [inner, outer]
}
