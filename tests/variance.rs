//! The examples' own technique, tested as it stands there.

#[path = "../examples/variance/variance.rs"]
mod example;

pub use example::Variance;
