//! Detailed surfaces: tangents, normal maps, textures from files, displacement denoising.

pub mod denoise;
mod files;
mod normal_map;
mod pixels;
mod tangents;

pub(crate) use files::TextureFiles;
pub use normal_map::fitting_normal_map;
#[cfg(feature = "gltf")]
pub(crate) use pixels::{EncodedImage, PendingImages};
pub(crate) use pixels::{Meaning, PICTURE_SIDE, kinds_of_pictures, picture_format};
pub use tangents::with_tangents;

/// Cut-off of alpha textures in files that don't set one: glTF's default.
pub(crate) const USUAL_CUTOFF: f32 = 0.5;
