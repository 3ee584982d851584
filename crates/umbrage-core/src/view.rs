//! What a technique looks at.

use crate::{Aabb, Camera, FitMemory, Geometry, Invalid, Light, Receivers};

/// All that a technique may look at.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// Who sees.
    pub camera: &'a Camera,
    /// What shines.
    pub light: &'a Light,
    /// Box around all casters, world space; empty when nothing casts.
    pub casters: Aabb,
    /// The triangles; none when they live on the caller's GPU.
    pub geometry: Option<&'a Geometry>,
    /// What is seen, when it is known; else backends find out from the geometry.
    pub receivers: Option<&'a Receivers>,
    /// The fits that were found for this camera, light, geometry and these receivers, to be used again; none to search anew.
    pub fits: Option<&'a FitMemory>,
}

impl<'a> View<'a> {
    /// A view of a scene's triangles.
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

    /// Objects to a camera or a light that can't be used, and to boxes and receivers with numbers that are not finite.
    ///
    /// # Errors
    /// The first fault found.
    pub fn validate(&self) -> Result<(), Invalid> {
        self.camera.validate()?;
        self.light.validate()?;
        self.casters
            .validate()
            .map_err(|e| e.within("view's casters"))?;
        self.receivers.map_or(Ok(()), Receivers::validate)
    }

    /// The same view with its receivers known. Fits that were found for others are not taken along.
    #[must_use]
    pub fn with_receivers(self, receivers: &'a Receivers) -> Self {
        Self {
            receivers: Some(receivers),
            fits: None,
            ..self
        }
    }

    /// The same view, whose fits are remembered. A memory serves one view: one camera, light, geometry and set of receivers.
    #[must_use]
    pub fn with_fits(self, fits: &'a FitMemory) -> Self {
        Self {
            fits: Some(fits),
            ..self
        }
    }
}
