//! Areas of unions of convex polygons, from their outlines: by Green's theorem, the integral of
//! half the cross product of position and step over those parts of the sides that no other polygon
//! covers.
//!
//! It shares no code with the cutting of lit areas, whose sum it checks.

use crate::{
    frame::cross,
    grid::Rectangle,
    tree::{self, Scene, Stack},
};
use glam::{DVec2, Vec3Swizzles as _};
use std::f64::consts::{PI, TAU};

/// Returns the parts of the integral over the outline of all facets that are in a tile. Their sum
/// over all tiles is the area of the silhouette, square metres.
pub(crate) fn outline_integrals(scene: &Scene, margin: f64) -> Vec<Vec<f64>> {
    scene.map_parts(|search: &mut OutlineSearch, index, cell| {
        search.integral(scene, index, margin, cell)
    })
}

#[derive(Default)]
struct OutlineSearch {
    stack: Stack,
    covered: Vec<[f64; 2]>,
}

impl OutlineSearch {
    /// Returns the integral over the uncovered parts of a facet's sides, within a cell if one is
    /// given.
    fn integral(&mut self, scene: &Scene, index: u32, margin: f64, cell: Option<Rectangle>) -> f64 {
        let corners = scene.facets[index as usize].corners;
        let origin = corners[0].xy();
        let mut integral = 0.0;
        for [from, to] in [[0, 1], [1, 2], [2, 0]].map(|side| side.map(|i| corners[i])) {
            let within = match cell {
                None => Some([0.0, 1.0]),
                Some(cell) => inside_rectangle([from.xy(), to.xy()], cell),
            };
            let Some(within) = within else {
                continue;
            };
            let query = tree::query_all(within.map(|fraction| from.lerp(to, fraction)));
            let side = [from.xy() - origin, to.xy() - origin];
            let covered = &mut self.covered;
            covered.clear();
            scene.visit_overlapping(&query, &mut self.stack, |other| {
                if other == index {
                    return false;
                }
                let polygon = scene.facets[other as usize]
                    .corners
                    .map(|c| c.xy() - origin);
                let part = covered_part(side, &polygon, other < index, margin);
                covered.extend(part);
                part.is_some_and(|part| part[0] <= within[0] && part[1] >= within[1])
            });
            integral += side_integral([from.xy(), to.xy()], within, covered);
        }
        integral
    }
}

/// Returns the fractions of a side between which it is inside a rectangle, whose greatest
/// coordinates are outside.
fn inside_rectangle(side: [DVec2; 2], rectangle: Rectangle) -> Option<[f64; 2]> {
    let [from, to] = side.map(|p| p.to_array());
    let [low, high] = rectangle.map(|p| p.to_array());
    let mut within = [0.0_f64, 1.0_f64];
    for axis in 0..2 {
        let step = to[axis] - from[axis];
        if step == 0.0 {
            let is_inside = low[axis] <= from[axis] && from[axis] < high[axis];
            within[1] = if is_inside { within[1] } else { 0.0 };
            continue;
        }
        let ends = [low[axis], high[axis]].map(|end| (end - from[axis]) / step);
        within[0] = within[0].max(ends[0].min(ends[1]));
        within[1] = within[1].min(ends[0].max(ends[1]));
    }
    (within[0] < within[1]).then_some(within)
}

/// Returns the fractions of a side between which a convex polygon covers the points just to the
/// right of it. Of equal sides of two polygons, one is covered: that of the other polygon, if this
/// one `precedes`. Sides within the margin are equal: at crossings of nearly parallel ones, two
/// roundings of the crossing would leave a gap in the outline.
fn covered_part(
    side: [DVec2; 2],
    polygon: &[DVec2],
    precedes: bool,
    margin: f64,
) -> Option<[f64; 2]> {
    let [from, to] = side;
    let mut part = [0.0_f64, 1.0_f64];
    let side_length_squared = (to - from).length_squared();
    let [.., last] = polygon else {
        return None;
    };
    let mut a = *last;
    for &b in polygon {
        let edge = b - a;
        let values = [cross(edge, from - a), cross(edge, to - a)];
        // Compare the shorter side with the line of the longer one, which is not extrapolated.
        let is_on_line = if edge.length_squared() >= side_length_squared {
            is_within(values, edge, margin)
        } else {
            let step = to - from;
            is_within([cross(step, a - from), cross(step, b - from)], step, margin)
        };
        match values {
            // The polygon is to the right of the side if its edge has the other direction.
            _ if is_on_line && (edge.dot(to - from) <= 0.0 || precedes) => (),
            _ if is_on_line => return None,
            [v, w] if v <= 0.0 && w <= 0.0 => return None,
            [v, w] if v < 0.0 => part[0] = part[0].max(v / (v - w)),
            [v, w] if w < 0.0 => part[1] = part[1].min(v / (v - w)),
            _ => (),
        }
        a = b;
    }
    (part[0] < part[1]).then_some(part)
}

/// Returns whether points are within the margin of a line, given the cross products of the line's
/// step and their positions.
fn is_within(products: [f64; 2], step: DVec2, margin: f64) -> bool {
    // The sum of a vector's coordinates is at least its length.
    let slack = (step.x.abs() + step.y.abs()) * margin;
    products.iter().all(|product| product.abs() <= slack)
}

/// Returns the integral over a part of a side without its covered parts.
fn side_integral(side: [DVec2; 2], within: [f64; 2], covered: &mut [[f64; 2]]) -> f64 {
    let [from, to] = side;
    covered.sort_unstable_by(|a, b| a[0].total_cmp(&b[0]));
    let integral =
        |start: f64, end: f64| 0.5 * cross(from.lerp(to, start), (to - from) * (end - start));
    let mut sum = 0.0;
    let mut start = within[0];
    for part in covered.iter() {
        if part[0] >= within[1] {
            break;
        }
        if part[0] > start {
            sum += integral(start, part[0]);
        }
        start = start.max(part[1]);
    }
    if start < within[1] {
        sum += integral(start, within[1]);
    }
    sum
}

/// Returns the share of a disc around the origin that convex polygons (counter-clockwise) cover.
pub(crate) fn covered_share(radius: f64, polygons: &[Vec<DVec2>]) -> f64 {
    let mut area = covered_arcs(radius, polygons) * 0.5 * radius * radius;
    let mut covered = Vec::new();
    let margin = radius * 1e-13;
    for (i, polygon) in polygons.iter().enumerate() {
        let [.., last] = &polygon[..] else {
            continue;
        };
        let mut from = *last;
        for &to in polygon {
            if let Some(within) = inside_disc([from, to], radius) {
                covered.clear();
                let others = polygons.iter().enumerate().filter(|&(j, _)| j != i);
                covered
                    .extend(others.filter_map(|(j, o)| covered_part([from, to], o, j < i, margin)));
                area += side_integral([from, to], within, &mut covered);
            }
            from = to;
        }
    }
    (area / (PI * radius * radius)).clamp(0.0, 1.0)
}

/// Returns the fractions of a side between which it is inside the disc.
fn inside_disc(side: [DVec2; 2], radius: f64) -> Option<[f64; 2]> {
    let [from, to] = side;
    let step = to - from;
    // Solve |from + t step|² = radius² for t.
    let a = step.length_squared();
    let half_b = from.dot(step);
    let nearest_squared = cross(from, step).powi(2) / a;
    let root = (a * (radius * radius - nearest_squared)).sqrt();
    let start = ((-half_b - root) / a).max(0.0);
    let end = ((-half_b + root) / a).min(1.0);
    // False for sides without a length and those that miss the disc, whose root is not a number.
    (start < end && root >= 0.0).then_some([start, end])
}

/// Returns the sum of the angles of the disc's outline that polygons cover, radians.
fn covered_arcs(radius: f64, polygons: &[Vec<DVec2>]) -> f64 {
    // Angles at which the outline enters or leaves a polygon.
    let mut angles = vec![-PI, PI];
    for polygon in polygons {
        let next = polygon.iter().cycle().skip(1);
        for (&from, &to) in polygon.iter().zip(next) {
            let step = to - from;
            let normal = DVec2::new(-step.y, step.x);
            let half = (normal.dot(from) / (normal.length() * radius)).acos();
            // Not a number if the side's line misses the disc.
            if half.is_finite() {
                let middle = normal.y.atan2(normal.x);
                angles.extend([middle - half, middle + half].map(|a| a - TAU * (a / TAU).round()));
            }
        }
    }
    angles.sort_unstable_by(f64::total_cmp);
    let mut sum = 0.0;
    for pair in angles.windows(2) {
        let middle = DVec2::from_angle(0.5 * (pair[0] + pair[1])) * radius;
        if polygons.iter().any(|polygon| contains(polygon, middle)) {
            sum += pair[1] - pair[0];
        }
    }
    sum
}

fn contains(polygon: &[DVec2], p: DVec2) -> bool {
    let next = polygon.iter().cycle().skip(1);
    let mut sides = polygon.iter().zip(next);
    sides.all(|(&a, &b)| cross(b - a, p - a) >= 0.0)
}
