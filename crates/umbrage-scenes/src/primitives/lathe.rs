//! Solids of revolution about the y axis.

use super::{bare, on_circle};
use umbrage_core::Mesh;
use umbrage_core::glam::Vec3;

/// Turns a profile of (radius, height) about the y axis. It runs from bottom to top; its two ends count as on the axis,
/// so that the solid is closed. `2 * segments * (points - 2)` triangles.
pub(crate) fn lathe(profile: &[(f32, f32)], segments: u32) -> Mesh {
    let rings = &profile[1..profile.len() - 1];
    let mut positions = Vec::with_capacity(rings.len() * segments as usize + 2);
    for &(r, y) in rings {
        positions.extend((0..segments).map(|i| {
            let (cos, sin) = on_circle(f64::from(i) / f64::from(segments));
            // Towards -z, so that rings run counter-clockwise seen from above.
            Vec3::new(r * cos, y, -r * sin)
        }));
    }
    positions.extend([profile[0], profile[profile.len() - 1]].map(|(_, y)| Vec3::new(0.0, y, 0.0)));
    let triangles = capped_rings(rings.len() as u32, segments);
    bare("lathe", positions, triangles)
}

/// An upright cylinder that stands at height 0.
pub(crate) fn pillar(radius: f32, height: f32, segments: u32) -> Mesh {
    lathe(
        &[(0.0, 0.0), (radius, 0.0), (radius, height), (0.0, height)],
        segments,
    )
}

/// Triangles between `rings` rings of `segments` vertices, each counter-clockwise seen against the direction in which
/// they follow each other, closed by two last vertices: one before the first ring, one after the last.
pub(super) fn capped_rings(rings: u32, segments: u32) -> Vec<[u32; 3]> {
    let next = |i: u32| (i + 1) % segments;
    let (first, last) = (rings * segments, rings * segments + 1);
    let top = (rings - 1) * segments;
    let mut out: Vec<[u32; 3]> = (0..segments).map(|i| [first, next(i), i]).collect();
    for ring in 0..rings - 1 {
        let (lower, upper) = (ring * segments, (ring + 1) * segments);
        out.extend((0..segments).flat_map(|i| {
            let [a, b, c, d] = [lower + i, lower + next(i), upper + next(i), upper + i];
            [[a, b, c], [a, c, d]]
        }));
    }
    out.extend((0..segments).map(|i| [last, top + i, top + next(i)]));
    out
}
