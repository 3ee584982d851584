//! Tests of the backend through its public interface.

mod errors;
mod modes;
mod render;
mod shading;
mod stage;
