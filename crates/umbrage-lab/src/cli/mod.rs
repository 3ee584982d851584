//! The commands that measure shadow techniques: a program of yours becomes `compare`, `stability`,
//! `plan`, `which`, `bias`, `bench`, `card`, `wgsl` and `merge` by one call.
//!
//! ```no_run
//! use umbrage_lab::cli::Program;
//!
//! fn main() -> std::process::ExitCode {
//!     Program::default().run()
//! }
//! ```
//!
//! Techniques of your own come in by [`Program::with`]; `examples/measure.rs` in the repository
//! does that.

mod args;
mod bench;
mod bias;
mod card;
mod compare;
mod cost;
mod costs;
mod figures_table;
mod inputs;
mod list;
mod merge;
mod plan;
mod planning;
mod presets;
mod program;
mod progress;
mod regret;
mod run;
mod stability;
mod stability_summary;
mod stability_tables;
mod summary;
mod table;
mod usage;
mod verdicts;
mod wgsl;
mod which;

pub use program::{LightSetRatios, Program};
