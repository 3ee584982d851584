//! Tests of the backend on a real adapter. Without an adapter these tests fail, with the command
//! that installs a software one.

mod comparing;
mod counting;
mod drivers;
mod embedded;
mod embedded_inputs;
mod embedded_lights;
mod embedded_modes;
mod errors;
mod foreign;
mod formats;
mod from_depth;
mod kernels;
mod light_set;
mod peeling;
mod probing;
mod random_faces;
mod render;
mod replay;
mod scene;
mod shading;
mod sources;
