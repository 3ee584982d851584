//! Unions and differences of polygons by `i_overlay`'s 64-bit engine.

use crate::meshes::Mesh;
use i_overlay::{
    core::{fill_rule::FillRule, overlay_rule::OverlayRule},
    float::{simplify::SimplifyShape, single::SingleFloatOverlay},
};
use umbrage_surfaces::glam::DVec3;

type Contour = Vec<[f64; 2]>;

/// Axes across a direction, independent of the library's.
pub(crate) fn axes(sun: DVec3) -> [DVec3; 2] {
    let x = sun.any_orthonormal_vector();
    [x, sun.cross(x)]
}

fn across(p: DVec3, axes: [DVec3; 2]) -> [f64; 2] {
    axes.map(|axis| axis.dot(p))
}

fn contour(corners: &[DVec3], axes: [DVec3; 2]) -> Contour {
    let mut contour: Contour = corners.iter().map(|&p| across(p, axes)).collect();
    if twice_area(&contour) < 0.0 {
        contour.reverse();
    }
    contour
}

fn twice_area(contour: &Contour) -> f64 {
    let origin = contour[0];
    let vector = |p: [f64; 2]| [p[0] - origin[0], p[1] - origin[1]];
    let pairs = contour
        .windows(2)
        .map(|pair| [vector(pair[0]), vector(pair[1])]);
    pairs.map(|[a, b]| a[0] * b[1] - a[1] * b[0]).sum()
}

fn area(shapes: &[Vec<Contour>]) -> f64 {
    shapes
        .iter()
        .flatten()
        .map(|contour| 0.5 * twice_area(contour))
        .sum()
}

/// Returns the area of the silhouette of some triangles.
pub(crate) fn union_area(triangles: impl Iterator<Item = [DVec3; 3]>, sun: DVec3) -> f64 {
    let axes = axes(sun);
    let contours: Vec<Contour> = triangles.map(|corners| contour(&corners, axes)).collect();
    area(&contours.simplify_shape_as::<i64>(FillRule::NonZero))
}

/// Returns the lit area of a facet across the light: its triangle minus the parts of all other ones
/// above its plane. Of facets in the same plane, the one with the lower row is above.
pub(crate) fn lit_area(mesh: &Mesh, row: usize, sun: DVec3) -> f64 {
    let axes = axes(sun);
    let corners = mesh.corners(row);
    let normal = (corners[1] - corners[0])
        .cross(corners[2] - corners[0])
        .normalize();
    let normal = normal * normal.dot(sun).signum();
    let mut above = Vec::new();
    for other in (0..mesh.triangles.len()).filter(|&other| other != row) {
        let caster = mesh.corners(other);
        let heights = caster.map(|p| {
            let height = normal.dot(p - corners[0]);
            if height.abs() < 1e-11 { 0.0 } else { height }
        });
        if heights == [0.0; 3] {
            above.extend((other < row).then(|| contour(&caster, axes)));
            continue;
        }
        let mut part = Vec::new();
        for i in 0..3 {
            let j = (i + 1) % 3;
            if heights[i] >= 0.0 {
                part.push(caster[i]);
            }
            if heights[i] * heights[j] < 0.0 {
                part.push(caster[i].lerp(caster[j], heights[i] / (heights[i] - heights[j])));
            }
        }
        if part.len() > 2 {
            above.push(contour(&part, axes));
        }
    }
    let subject = vec![contour(&corners, axes)];
    let rest = subject.overlay_as::<i64>(&above, OverlayRule::Difference, FillRule::NonZero);
    area(&rest)
}
