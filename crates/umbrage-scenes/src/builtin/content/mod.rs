//! Scenes like those of games and films: interiors, streets, plants, landscapes, figures. Each
//! exists with a light without extent and with an area light.

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

/// Size of the images.
const SIZE: [u32; 2] = [1280, 720];
