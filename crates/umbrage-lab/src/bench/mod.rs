//! Speed as ratios of two things that do the same work, run in turn on the same machine.
//!
//! Machines are noisy and drift; a ratio of neighbours in time holds all the same. Benchmark
//! harnesses time one thing after the other has finished, so the turns are taken here.

mod handwritten;
mod lists;
mod paired;
mod rays;
mod soft;
mod suite;

pub use lists::lists;
pub use paired::{Pair, PairTimes, Paired, Repetitions, paired};
pub use soft::soft;
pub use suite::{BenchOptions, run};
