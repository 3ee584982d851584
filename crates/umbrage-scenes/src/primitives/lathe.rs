//! Solids of revolution about the y axis.

use super::{bare, on_circle};
use umbrage_core::Mesh;
use umbrage_core::glam::Vec3;

/// Revolves a profile of (radius, height) about the y axis, from bottom to top. Both ends are
/// treated as on the axis, so that the solid is closed. It has `2 * segments * (points - 2)`
/// triangles.
pub(crate) fn lathe(profile: &[(f32, f32)], segments: u32) -> Mesh {
    let rings = &profile[1..profile.len() - 1];
    let mut positions = Vec::with_capacity(rings.len() * segments as usize + 2);
    for &(r, y) in rings {
        positions.extend((0..segments).map(|i| {
            let turn = f64::from(i) / f64::from(segments);
            let (cos, sin) = on_circle(turn);
            // Turn towards -z, so that rings are counter-clockwise seen from above.
            Vec3::new(r * cos, y, -r * sin)
        }));
    }
    let bottom = profile[0];
    let top = profile[profile.len() - 1];
    for (_, y) in [bottom, top] {
        positions.push(Vec3::new(0.0, y, 0.0));
    }
    let triangles = capped_rings(rings.len() as u32, segments);
    bare("lathe", positions, triangles)
}

/// An upright cylinder whose foot is at height 0.
pub(crate) fn pillar(radius: f32, height: f32, segments: u32) -> Mesh {
    lathe(
        &[(0.0, 0.0), (radius, 0.0), (radius, height), (0.0, height)],
        segments,
    )
}

/// Returns the triangles between `rings` rings of `segments` vertices, each counter-clockwise seen
/// against the order of rings. Two last vertices close them: one before the first ring, one after
/// the last.
pub(super) fn capped_rings(rings: u32, segments: u32) -> Vec<[u32; 3]> {
    let next = |i: u32| (i + 1) % segments;
    let first = rings * segments;
    let last = first + 1;
    let top = (rings - 1) * segments;
    let mut out: Vec<[u32; 3]> = (0..segments).map(|i| [first, next(i), i]).collect();
    for ring in 0..rings - 1 {
        let lower = ring * segments;
        let upper = lower + segments;
        for i in 0..segments {
            let a = lower + i;
            let b = lower + next(i);
            let c = upper + next(i);
            let d = upper + i;
            out.push([a, b, c]);
            out.push([a, c, d]);
        }
    }
    out.extend((0..segments).map(|i| [last, top + i, top + next(i)]));
    out
}
