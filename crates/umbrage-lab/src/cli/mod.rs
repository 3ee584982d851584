//! The commands that measure shadow techniques: `compare`, `stability`, `plan`, `which`, `bias`,
//! `bench`, `card`, `wgsl` and `merge`.
//!
//! One call adds them to your own program:
//!
//! ```no_run
//! use umbrage_lab::cli::Program;
//!
//! fn main() -> std::process::ExitCode {
//!     Program::default().run()
//! }
//! ```
//!
//! [`Program::with`] adds your own techniques, as `examples/measure.rs` in the repository does.

mod args;
mod bench;
mod bias;
mod card;
mod compare;
mod cost;
mod costs;
mod figures_table;
mod inputs;
mod left_out_limits;
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
