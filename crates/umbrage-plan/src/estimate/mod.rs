//! Estimates the errors of settings from a sample of the image.
//!
//! * [`scene`]: what the camera sees, and how techniques are tried on it.
//! * [`density`]: where in the image there is something to learn. [`sample`]: the pixels drawn
//!   accordingly.
//! * [`sampled_truth`]: a sample and the truth there. [`error`]: the error of the whole image,
//!   estimated from it.
//! * [`verify`]: the error once more, from a second sample that is a setting's own.
//! * [`weighting`]: how much each pixel's error counts.
//! * [`grain`]: noise that a blur would remove. [`shimmer`]: what changes as the camera moves.
//! * [`penumbra`]: how wide penumbrae are.

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
