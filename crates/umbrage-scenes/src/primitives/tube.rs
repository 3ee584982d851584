//! Bent tubes.

use super::{bare, lathe::capped_rings, on_circle};
use umbrage_core::Mesh;
use umbrage_core::glam::Vec3;

/// A tube of round cross-section along a path of (centre, radius), capped at both ends.
pub(crate) fn tube(path: &[(Vec3, f32)], segments: u32) -> Mesh {
    let mut positions = Vec::with_capacity(path.len() * segments as usize + 2);
    let mut side = (path[1].0 - path[0].0).any_orthonormal_vector();
    for (i, &(center, radius)) in path.iter().enumerate() {
        let tangent = path[(i + 1).min(path.len() - 1)].0 - path[i.saturating_sub(1)].0;
        // Transport the frame along the path, so that neighbouring rings don't twist.
        side = side.reject_from(tangent).normalize();
        let other = tangent.normalize().cross(side);
        positions.extend((0..segments).map(|k| {
            let (cos, sin) = on_circle(f64::from(k) / f64::from(segments));
            center + (side * cos + other * sin) * radius
        }));
    }
    positions.extend([path[0].0, path[path.len() - 1].0]);
    bare("tube", positions, capped_rings(path.len() as u32, segments))
}
