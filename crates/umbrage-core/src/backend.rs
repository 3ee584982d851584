//! The trait that a backend implements, and what it gives back.

use crate::{
    gbuffer::receivers::Receivers,
    invalid::Invalid,
    recipe::{Recipe, image::Image},
    snapping::Snapping,
    view::View,
};
use glam::UVec2;
use std::time::Duration;

/// Plays recipes.
pub trait Backend {
    /// For people: `cpu`, or `wgpu: NVIDIA H200 (Vulkan)`.
    fn name(&self) -> &str;

    /// A short word for file names and columns: `cpu` or `wgpu`.
    fn kind(&self) -> &'static str;

    /// How its rasteriser rounds vertices.
    fn snapping(&self) -> Snapping {
        Snapping::default()
    }

    /// Plays a recipe. Without `view.receivers`, receivers come from `view.geometry`.
    ///
    /// # Errors
    /// Errors if input is missing or bad, or the device fails.
    fn render(&mut self, view: &View<'_>, recipe: &Recipe) -> Result<Shadows, BackendError>;
}

/// A rendered shadow mask.
#[derive(Clone, Debug)]
pub struct Shadows {
    /// Image size, pixels.
    pub size: UVec2,
    /// Visibility of the light, 0..=1, rows from the top; 1 where nothing is seen or nothing
    /// receives.
    pub mask: Vec<f32>,
    /// The receivers that the backend made, if the view had none.
    pub receivers: Option<Receivers>,
    /// Linear colours, rows from the top, if the recipe shades.
    pub picture: Option<Vec<[f32; 4]>>,
    /// The recipe's images, if it asked for them.
    pub images: Vec<Image>,
    /// How long the stages took.
    pub timings: Timings,
    /// Bytes held for images, tables and receivers.
    pub bytes: u64,
}

impl Shadows {
    /// The mask as bytes, 0 dark to 255 lit, for saving as an 8-bit grey picture.
    pub fn mask_bytes(&self) -> Vec<u8> {
        self.mask
            .iter()
            .map(|v| (v.clamp(0.0, 1.0) * 255.0).round() as u8)
            .collect()
    }
}

/// How long the stages took, without compilation, upload and read-back. `None`: not played, or not
/// measurable here.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Timings {
    /// Finding the receivers.
    pub receivers: Option<Duration>,
    /// All casts.
    pub cast: Option<Duration>,
    /// All filters.
    pub filter: Option<Duration>,
    /// The lookup.
    pub receive: Option<Duration>,
}

impl Timings {
    /// Casts, filters and lookup together: what shadows cost a frame.
    pub fn total(&self) -> Duration {
        [self.cast, self.filter, self.receive]
            .into_iter()
            .flatten()
            .sum()
    }
}

/// Why a backend gave no mask.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BackendError {
    /// Input that cannot be used.
    #[error(transparent)]
    Invalid(#[from] Invalid),
    /// No graphics adapter that fits.
    #[error("no graphics adapter fits `{wanted}` (found: {found}); {help}")]
    NoAdapter {
        /// What was asked for.
        wanted: String,
        /// What there is.
        found: String,
        /// What to install or to ask for instead.
        help: String,
    },
    /// The device went away.
    #[error("the graphics device was lost: {0}; make a new backend")]
    DeviceLost(String),
    /// Not enough memory.
    #[error("out of memory: {0}; use smaller maps or images")]
    OutOfMemory(String),
    /// The graphics API objected: a fault of ours or of a user's kernel.
    #[error("the graphics API objected: {0}")]
    Validation(String),
}
