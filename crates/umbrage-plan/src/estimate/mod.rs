//! Estimation of the errors of settings from a sample of the image.
//!
//! * [`scene`]: the view of a camera, and the evaluation of techniques on it.
//! * [`density`]: the density of samples over the image. [`sample`]: pixels drawn with this
//!   density.
//! * [`sampled_truth`]: a sample and its truth. [`error`]: the estimated error of the whole image.
//! * [`verify`]: a second estimate of the error, from a separate sample for the setting.
//! * [`weighting`]: the weight of each pixel's error.
//! * [`grain`]: noise that a blur would remove. [`shimmer`]: changes as the camera moves.
//! * [`penumbra`]: the widths of penumbrae.

pub(crate) mod density;
pub(crate) mod error;
pub(crate) mod grain;
pub(crate) mod penumbra;
pub(crate) mod sample;
pub(crate) mod sampled_truth;
pub(crate) mod scene;
pub(crate) mod shimmer;
pub(crate) mod verify;
pub(crate) mod weighting;
