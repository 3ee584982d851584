//! Points, discs and hours, against rays in brute force and closed forms.

use umbrage_surfaces::glam::DVec3;

/// Returns whether a ray meets a triangle beyond a distance (Möller and Trumbore 1997, "Fast,
/// Minimum Storage Ray/Triangle Intersection").
pub(crate) fn hits(p: DVec3, direction: DVec3, corners: [DVec3; 3], beyond: f64) -> bool {
    let [a, b, c] = corners;
    let [e, f] = [b - a, c - a];
    let q = direction.cross(f);
    let determinant = e.dot(q);
    let s = p - a;
    let u = s.dot(q) / determinant;
    let r = s.cross(e);
    let v = direction.dot(r) / determinant;
    let t = f.dot(r) / determinant;
    u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > beyond
}
