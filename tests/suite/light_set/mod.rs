//! Light sets: many lights in one renderer, against the same lights alone, and against a set that
//! was made anew.

mod absurd;
mod alike;
mod budget;
mod device_lists;
mod devices;
mod edits;
mod hops;
mod masks;
mod turning;
