//! What settings err, estimated from a sample of the image.
//!
//! * [`scene`]: what the camera sees, and how techniques are tried on it.
//! * [`density`]: where in the image there is something to learn; [`sample`]: the pixels drawn accordingly.
//! * [`error`]: the error of the whole image from the sample's; [`verify`]: from a second sample, a setting's own.
//! * [`penumbra`]: how wide penumbrae are.

pub(crate) mod density;
pub(crate) mod error;
pub(crate) mod penumbra;
pub(crate) mod sample;
pub(crate) mod scene;
pub(crate) mod verify;
