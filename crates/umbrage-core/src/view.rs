//! The input of a technique.

use crate::{
    gbuffer::receivers::Receivers,
    geometry::{Geometry, aabb::Aabb},
    invalid::Invalid,
    light_space::fit::FitMemory,
    scene::{camera::Camera, light::Light},
};

/// All that a technique may depend on: one camera, one light, and the scene.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// The camera.
    pub camera: &'a Camera,
    /// The light.
    pub light: &'a Light,
    /// Box around all casters, world space; empty when nothing casts.
    pub casters: Aabb,
    /// The triangles; none when they live on the caller's GPU.
    pub geometry: Option<&'a Geometry>,
    /// What the camera sees, if it is known; else backends compute it from the geometry.
    pub receivers: Option<&'a Receivers>,
    /// Remembers the fits that were found for this camera, light, geometry and these receivers;
    /// none to search each time.
    pub fits: Option<&'a FitMemory>,
}

impl<'a> View<'a> {
    /// Returns a view of a scene's triangles, without known receivers.
    pub fn new(camera: &'a Camera, light: &'a Light, geometry: &'a Geometry) -> Self {
        Self {
            camera,
            light,
            casters: geometry.caster_bounds(),
            geometry: Some(geometry),
            receivers: None,
            fits: None,
        }
    }

    /// # Errors
    /// Errors if the camera or the light can't be used, or a number of the casters' box or the
    /// receivers is not finite: the first fault found.
    pub fn validate(&self) -> Result<(), Invalid> {
        self.camera.validate()?;
        self.light.validate()?;
        self.casters
            .validate()
            .map_err(|e| e.within("view's casters"))?;
        if self.fits.is_some_and(FitMemory::knows_receivers) {
            return Ok(());
        }
        self.receivers.map_or(Ok(()), Receivers::validate)
    }

    /// Returns the same view with its receivers known. Fits that were found for other receivers are
    /// left out.
    #[must_use]
    pub fn with_receivers(self, receivers: &'a Receivers) -> Self {
        Self {
            receivers: Some(receivers),
            fits: None,
            ..self
        }
    }

    /// Returns the same view, whose fits are remembered in `fits`. A memory serves one view: one
    /// camera, light, geometry and set of receivers.
    #[must_use]
    pub fn with_fits(self, fits: &'a FitMemory) -> Self {
        Self {
            fits: Some(fits),
            ..self
        }
    }
}
