//! The trait that a backend implements, and its output.

use crate::{
    gbuffer::receivers::Receivers,
    invalid::Invalid,
    recipe::{Recipe, image::Image},
    snapping::Snapping,
    view::View,
};
use glam::UVec2;
use std::time::Duration;

/// Executes recipes.
pub trait Backend {
    /// Full name for display: `cpu`, or `wgpu: NVIDIA H200 (Vulkan)`.
    fn name(&self) -> &str;

    /// Short name for file names and columns: `cpu` or `wgpu`.
    fn kind(&self) -> &'static str;

    /// Returns the vertex rounding of the backend's rasteriser.
    fn snapping(&self) -> Snapping {
        Snapping::default()
    }

    /// Executes a recipe. Computes receivers from `view.geometry` if `view.receivers` is `None`.
    ///
    /// # Errors
    /// Errors if input is missing or invalid, or the device fails.
    fn render(&mut self, view: &View<'_>, recipe: &Recipe) -> Result<Shadows, BackendError>;
}

/// A rendered shadow mask.
#[derive(Clone, Debug)]
pub struct Shadows {
    /// Image size, pixels.
    pub size: UVec2,
    /// Visibility of the light, 0..=1, rows from the top; 1 where a pixel is empty or receives no
    /// shadow.
    pub mask: Vec<f32>,
    /// Receivers that the backend computed; `None` if the view provided them.
    pub receivers: Option<Receivers>,
    /// Linear colours, rows from the top, if the recipe shades.
    pub picture: Option<Vec<[f32; 4]>>,
    /// The recipe's images, if it requests them.
    pub images: Vec<Image>,
    /// GPU or CPU time of each stage.
    pub timings: Timings,
    /// Bytes held for images, tables and receivers.
    pub bytes: u64,
}

impl Shadows {
    /// Returns the mask as bytes, 0 dark to 255 lit, for saving as an 8-bit grey image.
    pub fn mask_bytes(&self) -> Vec<u8> {
        self.mask
            .iter()
            .map(|v| (v.clamp(0.0, 1.0) * 255.0).round() as u8)
            .collect()
    }
}

/// Durations of the stages, without compilation, upload and readback. `None` if a stage did not
/// run, or can't be measured on this backend.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Timings {
    /// Computation of the receivers.
    pub receivers: Option<Duration>,
    /// All casts.
    pub cast: Option<Duration>,
    /// All filters.
    pub filter: Option<Duration>,
    /// The receive stage.
    pub receive: Option<Duration>,
}

impl Timings {
    /// Returns the sum of the cast, filter and receive stages: the shadow cost of a frame.
    pub fn total(&self) -> Duration {
        [self.cast, self.filter, self.receive]
            .into_iter()
            .flatten()
            .sum()
    }
}

/// Error of a backend.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BackendError {
    /// Input that cannot be used.
    #[error(transparent)]
    Invalid(#[from] Invalid),
    /// No graphics adapter matches the request.
    #[error("no graphics adapter matches `{wanted}` (found: {found}); {help}")]
    NoAdapter {
        /// The requested adapter.
        wanted: String,
        /// The available adapters.
        found: String,
        /// Advice: an adapter to install or request instead.
        help: String,
    },
    /// The device was lost.
    #[error("the graphics device was lost: {0}; create a new backend")]
    DeviceLost(String),
    /// Not enough memory.
    #[error("out of memory: {0}; use smaller maps or images")]
    OutOfMemory(String),
    /// The graphics API reported a validation error: a bug in umbrage or in a user's kernel.
    #[error("the graphics API reported a validation error: {0}")]
    Validation(String),
}
