//! Areas of unions of polygons, by `i_overlay` in 64-bit integers.
//!
//! The areas share no code with the cutting of lit areas, whose sum they check. They do share the
//! tree that finds the facets of a cell; tests compare them with the union of all facets at once.

use crate::tree::{self, Scene, Stack};
use glam::{DVec2, Vec3Swizzles as _};
use i_overlay::{
    core::{fill_rule::FillRule, overlay_rule::OverlayRule},
    float::{simplify::SimplifyShape as _, single::SingleFloatOverlay as _},
};
use std::f64::consts::PI;

/// The outline of a polygon, counter-clockwise; of a hole, clockwise.
pub(crate) type Contour = Vec<[f64; 2]>;

/// Returns the area of the facets' union within each cell of a tile, square metres. The sum over
/// all tiles is the area of the silhouette.
pub(crate) fn silhouette_areas(scene: &Scene) -> Vec<f64> {
    scene.map_cells(|stack: &mut Stack, cell| {
        let [low, high] = scene.rectangle(cell);
        let query = tree::query_all([low, high].map(|p| p.extend(0.0)));
        let mut contours: Vec<Contour> = Vec::new();
        scene.visit_overlapping(&query, stack, |index| {
            let corners = scene.facets[index as usize].corners;
            contours.push(corners.map(|corner| (corner.xy() - low).to_array()).into());
            false
        });
        let size = high - low;
        let rectangle: Contour = vec![[0.0, 0.0], [size.x, 0.0], size.to_array(), [0.0, size.y]];
        let union =
            contours.overlay_as::<i64>(&rectangle, OverlayRule::Intersect, FillRule::NonZero);
        union.iter().flatten().map(|contour| area(contour)).sum()
    })
}

/// Returns the area inside a contour, negative if it is clockwise.
fn area(contour: &[[f64; 2]]) -> f64 {
    let origin = contour.first().copied().map_or(DVec2::ZERO, DVec2::from);
    let corner = |p: [f64; 2]| DVec2::from(p) - origin;
    let triangles = contour.windows(2);
    triangles
        .map(|pair| 0.5 * corner(pair[0]).perp_dot(corner(pair[1])))
        .sum()
}

/// Returns the share of a disc around the origin that the union of some polygons covers.
pub(crate) fn union_share(radius: f64, polygons: &[&Contour]) -> f64 {
    if let [polygon] = polygons {
        return covered_share(radius, polygon);
    }
    let polygons: Vec<&[[f64; 2]]> = polygons.iter().map(|polygon| &polygon[..]).collect();
    let union = polygons.simplify_shape_as::<i64>(FillRule::NonZero);
    let contours = union.iter().flatten();
    let share: f64 = contours.map(|contour| covered_share(radius, contour)).sum();
    share.clamp(0.0, 1.0)
}

/// Returns the share of a disc around the origin that is inside a contour, negative if that is
/// clockwise.
pub(crate) fn covered_share(radius: f64, contour: &[[f64; 2]]) -> f64 {
    let sector = |from: DVec2, to: DVec2| radius * radius * from.perp_dot(to).atan2(from.dot(to));
    let next = contour.iter().cycle().skip(1);
    let mut twice_area = 0.0;
    for (&from, &to) in contour.iter().zip(next) {
        let [from, to] = [from, to].map(DVec2::from);
        // Sum the triangle between the centre and the side's part in the disc, and the sectors
        // between the centre and its parts outside.
        twice_area += match part_in_disc([from, to], radius) {
            Some([start, end]) => sector(from, start) + start.perp_dot(end) + sector(end, to),
            None => sector(from, to),
        };
    }
    0.5 * twice_area / (PI * radius * radius)
}

/// Returns the ends of the part of a side that is inside a disc around the origin.
fn part_in_disc(side: [DVec2; 2], radius: f64) -> Option<[DVec2; 2]> {
    let [from, to] = side;
    let step = to - from;
    // Solve |from + t step|² = radius² for t.
    let a = step.length_squared();
    let half_b = from.dot(step);
    let nearest_squared = from.perp_dot(step).powi(2) / a;
    let root = (a * (radius * radius - nearest_squared)).sqrt();
    let start = ((-half_b - root) / a).max(0.0);
    let end = ((-half_b + root) / a).min(1.0);
    // False for sides without a length and those that miss the disc, whose root is not a number.
    let is_inside = start < end && root >= 0.0;
    is_inside.then(|| [from.lerp(to, start), from.lerp(to, end)])
}
