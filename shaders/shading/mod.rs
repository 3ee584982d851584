//! Colour images: surface properties at visible points, and their shading with a shadow mask.

pub(crate) mod blinn_phong;
pub mod facing;
pub(crate) mod interpolation;
pub(crate) mod lighting;
pub(crate) mod surface;
pub(crate) mod surface_tables;
pub(crate) mod texture;
