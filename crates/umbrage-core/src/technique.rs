//! The trait that a shadow technique implements.

use crate::{Aabb, Camera, FitMemory, Geometry, Invalid, Light, Receivers, Recipe};
use std::fmt::Debug;

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

/// A way to make shadows: a pure function from what is seen to a recipe. Its parameters are its public fields.
pub trait ShadowTechnique: Debug + Send + Sync {
    /// The technique's name, in lower case: `pcf`.
    fn name(&self) -> &'static str;

    /// Its settings in a few words, without the name: `3x3, 1024, slope .05/.005`.
    fn settings(&self) -> String;

    /// The recipe for a view. The same view gives the same recipe.
    ///
    /// # Errors
    /// `Unsupported` when it can't serve this light or scene, with the reason; `Invalid` for bad parameters.
    fn plan(&self, view: &View<'_>) -> Result<Recipe, PlanError>;

    /// How far, in texels, lookups go beyond the point of a map on which a receiver falls, along each axis: 0 for one texel,
    /// 1 for the 3 x 3 around it. None where no map of what the light sees is looked up, and where that isn't known:
    /// reports then say nothing of its maps. Where it differs from one receiver
    /// to the next this is the narrowest, and [`ReceiveKernel::reach`](crate::ReceiveKernel::reach) says each.
    fn kernel_reach(&self) -> Option<f32> {
        None
    }
}

/// Why there is no recipe.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PlanError {
    /// The technique is not made for this: a value rather than a fault. Reports print a dash and the reason.
    #[error("not supported: {0}")]
    Unsupported(String),
    /// A parameter or the view can't be used.
    #[error(transparent)]
    Invalid(#[from] Invalid),
}

impl PlanError {
    /// The technique can't serve this, for this reason.
    pub fn unsupported(reason: impl Into<String>) -> Self {
        Self::Unsupported(reason.into())
    }
}
