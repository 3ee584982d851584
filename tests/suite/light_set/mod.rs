//! Tests of light sets: many lights in one renderer, compared with the same lights alone and with a
//! new set.

mod absurd;
mod alike;
mod budget;
mod device_hierarchies;
mod devices;
mod edits;
mod floor;
mod hops;
mod masks;
mod own_casters;
mod turning;
mod unknown_receivers;
mod wide_scenes;
