//! Speed as the ratio of two programs that do the same work, run in turn on the same machine.
//!
//! Machines are noisy and drift, but ratios of adjacent runs stay valid. Benchmark harnesses run
//! one program after the other, so this module alternates them itself.

mod handwritten;
mod lists;
mod paired;
mod rays;
mod soft;
mod suite;

pub use lists::lists;
pub use paired::{Pair, PairTimes, Paired, Repetitions, measure_pairs};
pub use soft::soft;
pub use suite::{BenchOptions, run};
