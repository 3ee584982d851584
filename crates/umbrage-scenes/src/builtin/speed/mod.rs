//! Large scenes, for measuring speed.

use umbrage_core::{Light, glam::Vec3};

pub(crate) mod hall;
pub(crate) mod statue;
pub(crate) mod terrain;
pub(crate) mod town;

/// Image size at which lookups are timed.
pub(crate) const SIZE: [u32; 2] = [1280, 720];

/// Returns a hazy sun of 3 degrees, as in the content scenes.
fn area_sun(x: f32, y: f32, z: f32) -> Light {
    Light::Directional {
        direction: Vec3::new(x, y, z),
        angular_diameter: 3.0_f32.to_radians(),
    }
}
