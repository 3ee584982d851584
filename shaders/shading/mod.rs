//! Colour pictures: what a seen surface is made of, and how it shades under the light that a mask
//! leaves it.

pub(crate) mod blinn_phong;
pub mod facing;
pub(crate) mod interpolation;
pub(crate) mod lighting;
pub(crate) mod surface;
pub(crate) mod surface_tables;
pub(crate) mod texture;
