//! Tests of lit areas, points, discs and hours against closed forms and independent oracles.

mod areas;
#[cfg(feature = "cli")]
mod command;
mod errors;
mod meshes;
mod oracle;
mod points;
