//! Scenes such as games and films are made of: interiors, streets, plants, land, figures. Each is
//! there under an ideal light and under a wide one.

pub(crate) mod dancer;
mod figure;
pub(crate) mod forest;
mod furniture;
mod house;
pub(crate) mod leaf_cards;
pub(crate) mod nave;
pub(crate) mod night_room;
mod parts;
mod plants;
pub(in crate::builtin) mod random;
pub(crate) mod street;
mod things;
pub(crate) mod valley;

#[cfg(test)]
mod tests;

/// The size of the pictures.
const SIZE: [u32; 2] = [1280, 720];
