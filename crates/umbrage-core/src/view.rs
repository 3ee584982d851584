//! The input of a technique.

use crate::{
    gbuffer::receivers::Receivers,
    geometry::{Geometry, aabb::Aabb},
    invalid::Invalid,
    light_space::fit::memory::FitMemory,
    scene::{camera::Camera, light::Light},
};

/// Input of a technique: one camera, one light, and the scene.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// The camera.
    pub camera: &'a Camera,
    /// The light.
    pub light: &'a Light,
    /// Box around all casters, world space; empty if there are no casters.
    pub casters: Aabb,
    /// Lower bound of the distance from the light's position to a caster, metres; 0 if unknown.
    /// Perspective maps start there if there are no triangles.
    pub nearest_caster: f32,
    /// The triangles; `None` if they exist only on the caller's GPU. Maps then end at the casters'
    /// box.
    pub geometry: Option<&'a Geometry>,
    /// The visible surface points, if known; otherwise backends compute them from the geometry.
    pub receivers: Option<&'a Receivers>,
    /// Cache of the fits found for this camera, light, geometry and these receivers. `None` to
    /// search each time.
    pub fits: Option<&'a FitMemory>,
}

impl<'a> View<'a> {
    /// Returns a view of a scene's triangles, without known receivers.
    pub fn new(camera: &'a Camera, light: &'a Light, geometry: &'a Geometry) -> Self {
        Self {
            camera,
            light,
            casters: geometry.caster_bounds(),
            nearest_caster: 0.0,
            geometry: Some(geometry),
            receivers: None,
            fits: None,
        }
    }

    /// Checks that the view can be used.
    ///
    /// # Errors
    /// Errors with the first fault found: an invalid camera or light, or a number in the casters'
    /// box or the receivers that is not finite.
    pub fn validate(&self) -> Result<(), Invalid> {
        self.camera.validate()?;
        self.light.validate()?;
        self.casters
            .validate()
            .map_err(|e| e.within_context("view's casters"))?;
        if self.fits.is_some_and(FitMemory::knows_receivers) {
            return Ok(());
        }
        self.receivers.map_or(Ok(()), Receivers::validate)
    }

    /// Returns the view with these receivers. The cache of fits is dropped, as it belongs to other
    /// receivers.
    #[must_use]
    pub fn with_receivers(self, receivers: &'a Receivers) -> Self {
        Self {
            receivers: Some(receivers),
            fits: None,
            ..self
        }
    }

    /// Returns the view with a cache of fits. A cache serves one view: one camera, light, geometry
    /// and set of receivers.
    #[must_use]
    pub fn with_fits(self, fits: &'a FitMemory) -> Self {
        Self {
            fits: Some(fits),
            ..self
        }
    }
}
