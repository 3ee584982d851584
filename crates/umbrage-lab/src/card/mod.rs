//! What a graphics card does: how it rounds, whether it agrees with the CPU, and how long it takes.
//!
//! `cargo xtask card` writes a [`Card`] as JSON. Those that are committed in `docs/cards` make up
//! `docs/cards.md`.

mod agreement;
mod data;
mod file;
mod page;
mod times;

pub use agreement::{
    BIT_SCENES, BitCounts, BitPair, compare_bits, exact_techniques, measure_agreement,
};
pub use data::{Card, CardAgreement, CardLimits, CardTime, SCHEMA};
pub use file::{read, read_all, read_prices, write};
pub use page::page;
pub use times::{FRAMES, measure_times};

#[cfg(test)]
mod tests;
