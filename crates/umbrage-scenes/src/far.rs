//! Coordinates far from the origin, such as those of maps (UTM) or of the whole earth (ECEF).
//!
//! Scenes have positions of 32 bits. Readers keep 64 bits until the scene's anchor is known: meshes
//! are stored near their own origins, and placements have the rest.

use umbrage_core::Anchor;
use umbrage_core::glam::{DAffine3, DVec3, Vec3};

/// Distance from the origin, in sizes of the geometry, from which it is far.
const FAR_SIZES: f64 = 8.0;

/// A bounding box in 64 bits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Box64 {
    pub(crate) min: DVec3,
    pub(crate) max: DVec3,
}

impl Box64 {
    pub(crate) const EMPTY: Self = Self {
        min: DVec3::INFINITY,
        max: DVec3::NEG_INFINITY,
    };

    pub(crate) fn add(&mut self, point: DVec3) {
        self.min = self.min.min(point);
        self.max = self.max.max(point);
    }

    /// Returns the corners after a transform.
    pub(crate) fn corners(&self, place: &DAffine3) -> [DVec3; 8] {
        std::array::from_fn(|i| {
            let pick = |bit: usize, axis: usize| match i >> bit & 1 {
                0 => self.min[axis],
                _ => self.max[axis],
            };
            place.transform_point3(DVec3::new(pick(0, 0), pick(1, 1), pick(2, 2)))
        })
    }

    /// Returns the anchor for this geometry: the origin, unless the geometry is far from it. Then
    /// it is the one nearest to the eye, or to the geometry if there is no eye near it.
    pub(crate) fn anchor(&self, eye: Option<DVec3>) -> Anchor {
        let center = self.min.midpoint(self.max);
        let reach = Anchor::REACH.max(FAR_SIZES * self.min.distance(self.max));
        // Distances of empty and of infinite boxes are NaN or infinite.
        let is_far = center.length() > reach;
        if !is_far {
            return Anchor::ORIGIN;
        }
        let eye = eye.filter(|eye| eye.distance(center) <= reach);
        // Beyond the greatest anchor, 32 bits can't hold the positions, which is an error later.
        Anchor::nearest_to(eye.unwrap_or(center)).unwrap_or(Anchor::ORIGIN)
    }
}

/// Returns positions near the origin, and the offset that was subtracted. The offset is zero unless
/// they are far from it.
pub(crate) fn near_origin(positions: &[DVec3]) -> (Vec<Vec3>, DVec3) {
    let mut bounds = Box64::EMPTY;
    positions.iter().for_each(|&position| bounds.add(position));
    let anchor = bounds.anchor(None);
    let near = positions.iter().map(|&position| anchor.position(position));
    (near.collect(), anchor.point())
}

/// Returns the notice of a scene whose reader chose an anchor.
pub(crate) fn notice(file: &str, anchor: Anchor) -> Option<String> {
    if anchor == Anchor::ORIGIN {
        return None;
    }
    let [x, y, z] = anchor.point().to_array();
    Some(format!(
        "{file}: far from the origin: positions are relative to `anchor = [{x}, {y}, {z}]`"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn anchor_of(center: DVec3, half: f64, eye: Option<DVec3>) -> DVec3 {
        let bounds = Box64 {
            min: center - half,
            max: center + half,
        };
        bounds.anchor(eye).point()
    }

    #[test]
    fn only_far_geometry_gets_an_anchor_near_its_camera() {
        let utm = DVec3::new(691_234.37, 412.2, -5_336_543.21);
        assert_eq!(
            anchor_of(utm, 10.0, None),
            DVec3::new(691_200.0, 0.0, -5_336_064.0)
        );
        let eye = utm + DVec3::new(1000.0, 0.0, 0.0);
        assert_eq!(
            anchor_of(utm, 10.0, Some(eye)),
            DVec3::new(692_224.0, 0.0, -5_336_064.0)
        );
        // An eye elsewhere is ignored, and so are huge or invalid positions.
        assert_eq!(
            anchor_of(utm, 10.0, Some(DVec3::ZERO)),
            anchor_of(utm, 10.0, None)
        );
        assert_eq!(anchor_of(DVec3::splat(1e300), 1.0, None), DVec3::ZERO);
        assert_eq!(anchor_of(DVec3::NAN, 1.0, None), DVec3::ZERO);
        assert_eq!(Box64::EMPTY.anchor(None), Anchor::ORIGIN);
        // A model of 4 km around its own ground, in millimetres or not, is near.
        assert_eq!(anchor_of(DVec3::splat(2000.0), 2000.0, None), DVec3::ZERO);
    }

    #[test]
    fn far_positions_keep_64_bits() {
        let far = DVec3::new(5_000_000.0, 0.0, 6_378_137.0);
        let small = DVec3::new(0.125, 0.001, 0.0625);
        let (near, offset) = near_origin(&[far, far + small]);
        let found = (near[1] - near[0]).as_dvec3();
        assert!(found.distance(small) < 1e-4, "{found}");
        assert_eq!(offset + near[0].as_dvec3(), far);
        let (same, none) = near_origin(&[small]);
        assert_eq!((same[0], none), (small.as_vec3(), DVec3::ZERO));
    }
}
