//! Triangulation of polygons: Meisters 1975, "Polygons Have Ears".

use umbrage_core::glam::{DVec2, DVec3, Vec3};

/// Cuts a polygon into triangles of the same orientation. Convex polygons become a fan from the
/// first corner; others are cut ear by ear. Polygons without an ear (self-crossing or without area)
/// become a fan, too. Indices refer to the corners.
pub(crate) fn triangulate(corners: &[Vec3]) -> Vec<[u32; 3]> {
    let flat = flatten(corners);
    let mut left: Vec<u32> = (0..corners.len() as u32).collect();
    let mut out = Vec::with_capacity(corners.len().saturating_sub(2));
    while left.len() > 3 && !is_convex(&flat, &left) {
        let Some(ear) = (0..left.len()).find(|&i| is_ear(&flat, &left, i)) else {
            break;
        };
        out.push(neighbours_of(&left, ear));
        left.remove(ear);
    }
    out.extend((1..left.len().saturating_sub(1)).map(|i| [left[0], left[i], left[i + 1]]));
    out
}

/// Projects a polygon along its mean normal (Newell's method), so that a convex one turns left at
/// all corners.
fn flatten(corners: &[Vec3]) -> Vec<DVec2> {
    let Some(first) = corners.first().map(|c| c.as_dvec3()) else {
        return Vec::new();
    };
    let at = |i: usize| corners[i % corners.len()].as_dvec3() - first;
    let normal: DVec3 = (0..corners.len()).map(|i| at(i).cross(at(i + 1))).sum();
    let normal = normal.normalize_or(DVec3::Z);
    let u = normal.any_orthonormal_vector();
    let v = normal.cross(u);
    (0..corners.len())
        .map(|i| DVec2::new(at(i).dot(u), at(i).dot(v)))
        .collect()
}

fn neighbours_of(left: &[u32], i: usize) -> [u32; 3] {
    [
        left[(i + left.len() - 1) % left.len()],
        left[i],
        left[(i + 1) % left.len()],
    ]
}

/// Returns twice the signed area of a triangle, given by indices.
fn area(flat: &[DVec2], triangle: [u32; 3]) -> f64 {
    let [a, b, c] = triangle.map(|i| flat[i as usize]);
    (b - a).perp_dot(c - a)
}

/// Reports whether a polygon turns left or not at all at each corner. Stars that wind twice also
/// do, but no triangulation of them is better than their fan.
fn is_convex(flat: &[DVec2], left: &[u32]) -> bool {
    (0..left.len()).all(|i| area(flat, neighbours_of(left, i)) >= 0.0)
}

fn is_ear(flat: &[DVec2], left: &[u32], i: usize) -> bool {
    let [a, b, c] = neighbours_of(left, i);
    let inside = |p: u32| {
        [[a, b, p], [b, c, p], [c, a, p]]
            .iter()
            .all(|&t| area(flat, t) >= 0.0)
    };
    // Ignore corners that coincide with one of the ear's, as at bridges to holes.
    let elsewhere = |p: u32| {
        [a, b, c]
            .iter()
            .all(|&q| flat[q as usize] != flat[p as usize])
    };
    area(flat, [a, b, c]) > 0.0 && !left.iter().any(|&p| elsewhere(p) && inside(p))
}

#[cfg(test)]
#[path = "polygon_tests.rs"]
mod tests;
