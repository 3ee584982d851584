//! The subject of measurements: a view of a scene with one light.

use serde::{Deserialize, Serialize};
use umbrage::{Aabb, Camera, Geometry, Light, View};

/// A camera, a light, and the scene.
#[derive(Clone, Serialize, Deserialize)]
pub(crate) struct Subject {
    pub camera: Camera,
    pub light: Light,
    pub geometry: Geometry,
    /// Bounding box for which a light set plans: slightly larger than the casters. The texels of
    /// maps depend on it.
    pub casters: Aabb,
}

impl PartialEq for Subject {
    fn eq(&self, other: &Self) -> bool {
        self.camera == other.camera
            && self.light == other.light
            && self.geometry.fingerprint() == other.geometry.fingerprint()
    }
}

impl Subject {
    /// Returns the view for which a light set plans.
    pub(crate) fn view(&self) -> View<'_> {
        View {
            casters: self.casters,
            ..View::new(&self.camera, &self.light, &self.geometry)
        }
    }
}
