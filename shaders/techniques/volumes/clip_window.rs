//! Clipping of shadow volumes' walls to the image.
//!
//! Walls extend beyond all geometry, so devices clip most of them at the image's borders. Some
//! devices then round the clipped ends of neighbours differently, or drop walls too thin for their
//! sub-pixel grid. A pixel between the two then has a wrong count. So walls are clipped at the
//! border in advance, at points that neighbours share.

use glam::{DMat4, DVec3, DVec4, UVec2};
use std::collections::HashMap;
use umbrage_core::LightSpace;

/// Distance inside the image's border at which walls end, pixels. The border is beyond the
/// outermost pixels' centres. The distance is more than the vertex snapping of any device's
/// sub-pixel grid.
const MARGIN: f64 = 0.25;

/// Image reduced by a margin, as the inner sides of planes through the eye.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ClipWindow {
    /// Left, right, bottom, top: positive dot products with homogeneous world positions are inside.
    planes: [DVec4; 4],
}

/// Intersection with the border, and the plane that is crossed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Crossing<T> {
    /// Position of the crossing.
    pub(crate) at: T,
    /// Number of the plane.
    pub(crate) plane: usize,
}

impl<T> Crossing<T> {
    fn map<U>(self, convert: impl FnOnce(T) -> U) -> Crossing<U> {
        Crossing {
            at: convert(self.at),
            plane: self.plane,
        }
    }
}

/// Part of an edge within the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct VisiblePart<T> {
    /// Position where it enters the image; `None` if it begins inside.
    pub(crate) enters: Option<Crossing<T>>,
    /// Position where it leaves the image; `None` if it never does.
    pub(crate) leaves: Option<Crossing<T>>,
}

impl<T> VisiblePart<T> {
    /// Edge that is not cut, since it is entirely within the image or entirely outside.
    pub(crate) const WHOLE: Self = Self {
        enters: None,
        leaves: None,
    };

    /// Returns the part with its positions converted, the entering one first.
    fn map<U>(self, mut convert: impl FnMut(T) -> U) -> VisiblePart<U> {
        VisiblePart {
            enters: self.enters.map(|c| c.map(&mut convert)),
            leaves: self.leaves.map(|c| c.map(&mut convert)),
        }
    }
}

impl ClipWindow {
    /// Returns the window of an image with this size, pixels, for a light space.
    pub(crate) fn new(space: &LightSpace, size: UVec2) -> Self {
        let clip_from_world: DMat4 =
            space.clip_from_view.as_dmat4() * space.view_from_world.as_dmat4();
        let [x, y, w] = [0, 1, 3].map(|i| clip_from_world.row(i));
        // The image is 2 wide and high in these coordinates.
        let inner = 1.0 - 2.0 * MARGIN / size.as_dvec2();
        Self {
            planes: [
                w * inner.x + x,
                w * inner.x - x,
                w * inner.y + y,
                w * inner.y - y,
            ],
        }
    }

    /// Returns the part within the image of the edge between two points, or `None` if there is
    /// none. Clips like Cyrus and Beck 1978, "Generalized two- and three-dimensional clipping".
    pub(crate) fn visible_part(&self, from: DVec3, to: DVec3) -> Option<VisiblePart<DVec3>> {
        let from = from.extend(1.0);
        let towards = to.extend(1.0) - from;
        // At `from + s * towards`, the distance to a plane is `distance + s * growth`; it is 0 at
        // the crossing.
        let mut enters: Option<Crossing<f64>> = None;
        let mut leaves: Option<Crossing<f64>> = None;
        for (plane, normal) in self.planes.iter().enumerate() {
            let distance = normal.dot(from);
            let growth = normal.dot(towards);
            if distance <= 0.0 && growth <= 0.0 {
                return None;
            }
            let s = -distance / growth;
            let crossing = Some(Crossing { at: s, plane });
            // The part begins at the last plane entered, and ends at the first one left.
            if distance <= 0.0 && enters.is_none_or(|c| s > c.at) {
                enters = crossing;
            }
            if growth < 0.0 && leaves.is_none_or(|c| s < c.at) {
                leaves = crossing;
            }
        }
        let leaves = leaves.filter(|c| c.at < 1.0);
        let last = leaves.map_or(1.0, |c| c.at);
        let begins_before_end = enters.is_none_or(|c| c.at < last);
        if !begins_before_end {
            return None;
        }
        let part = VisiblePart { enters, leaves };
        Some(part.map(|s| (from + towards * s).truncate()))
    }
}

#[cfg(test)]
impl ClipWindow {
    /// Returns whether an edge is outside a plane, or on it within the rounding of its ends to 32
    /// bits.
    pub(crate) fn hides(&self, edge: [DVec4; 2]) -> bool {
        self.planes.iter().any(|plane| {
            edge.iter()
                .all(|end| plane.dot(*end) < 1e-5 * plane.abs().dot(end.abs()))
        })
    }
}

/// Parts of edges found so far, by the vertex at which they begin.
#[derive(Debug, Default)]
pub(crate) struct VisibleParts(HashMap<u32, VisiblePart<u32>>);

impl VisibleParts {
    /// Returns the part of the edge that begins at a vertex. Calls `find` once for each vertex.
    /// Calls `add` for each cut of the edge, to create a vertex.
    pub(crate) fn edge_part(
        &mut self,
        vertex: u32,
        find: impl FnOnce() -> Option<VisiblePart<DVec3>>,
        add: impl FnMut(DVec3) -> u32,
    ) -> VisiblePart<u32> {
        let part = self.0.entry(vertex).or_insert_with(|| match find() {
            Some(part) => part.map(add),
            None => VisiblePart::WHOLE,
        });
        *part
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage_core::{Camera, glam::Vec3};

    fn camera() -> Camera {
        let eye = Vec3::new(0.0, 0.0, 5.0);
        let size = UVec2::new(100, 50);
        Camera::perspective(eye, Vec3::ZERO, Vec3::Y, 1.0, [0.1, 100.0], size).expect("valid")
    }

    fn part(from: DVec3, to: DVec3) -> Option<VisiblePart<DVec3>> {
        ClipWindow::new(&camera().space(), camera().size).visible_part(from, to)
    }

    /// Returns the distances of a projected point from the image's four borders, pixels.
    fn borders(p: DVec3) -> [f64; 4] {
        let clip = camera().space().clip_from_world().as_dmat4() * p.extend(1.0);
        let x = 50.0 + 50.0 * clip.x / clip.w;
        let y = 25.0 - 25.0 * clip.y / clip.w;
        [x, 100.0 - x, 50.0 - y, y]
    }

    #[test]
    fn rays_cross_a_quarter_pixel_inside_the_border() {
        let from = DVec3::new(0.1, 0.2, 0.3);
        for (towards, plane) in [
            (DVec3::NEG_X, 0),
            (DVec3::X, 1),
            (DVec3::NEG_Y, 2),
            (DVec3::new(0.3, 1.0, -0.2), 3),
        ] {
            let inside = part(from, from + 1000.0 * towards).expect("it begins inside");
            let leaves = inside.leaves.expect("it leaves");
            assert_eq!((inside.enters, leaves.plane), (None, plane));
            // Test the reverse direction, from beyond the border.
            let beyond = leaves.at + (leaves.at - from);
            let back = part(beyond, from).expect("it enters");
            let enters = back.enters.expect("it begins outside");
            assert_eq!(enters.plane, plane);
            for at in [leaves.at, enters.at] {
                assert!(
                    (borders(at)[plane] - 0.25).abs() < 1e-4,
                    "{towards}: {:?}",
                    borders(at)
                );
                let across = (at - from).normalize().cross(towards.normalize()).length();
                assert!(across < 1e-9, "{towards}: {at} is not on the ray");
            }
        }
    }

    #[test]
    fn edges_outside_have_no_part_and_some_never_leave() {
        let right = DVec3::new(40.0, 0.0, 0.0);
        for (to, why) in [
            (right + 1000.0 * DVec3::Y, "right of the image"),
            (DVec3::new(0.0, 40.0, 0.0), "beyond its corner"),
            (DVec3::new(20.0, 0.0, 0.0), "ends before the image"),
        ] {
            assert_eq!(part(right, to), None, "{why}");
        }
        let behind = DVec3::new(0.0, 0.0, 6.0);
        assert_eq!(part(behind, behind + DVec3::Z), None, "behind the eye");
        for (to, why) in [
            (DVec3::new(0.1, 0.0, 0.0), "within the image"),
            (1000.0 * DVec3::NEG_Z, "away from the eye"),
        ] {
            assert_eq!(part(DVec3::ZERO, to), Some(VisiblePart::WHOLE), "{why}");
        }
    }

    #[test]
    fn a_part_is_found_once() {
        let mut parts = VisibleParts::default();
        let found = VisiblePart {
            enters: None,
            leaves: Some(Crossing {
                at: DVec3::ONE,
                plane: 2,
            }),
        };
        let kept = VisiblePart {
            enters: None,
            leaves: Some(Crossing { at: 9, plane: 2 }),
        };
        assert_eq!(parts.edge_part(5, || Some(found), |_| 9), kept);
        assert_eq!(parts.edge_part(5, || None, |_| 10), kept);
        assert_eq!(parts.edge_part(6, || None, |_| 10), VisiblePart::WHOLE);
    }
}
