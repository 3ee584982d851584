//! The player on a real adapter. A missing adapter fails these tests, with the line that installs a software one.

mod embedded;
mod errors;
mod foreign;
mod from_depth;
mod kernels;
mod render;
mod replay;
mod scene;
