//! Measurements of a graphics card: rounding, agreement with the CPU, and times.
//!
//! `cargo xtask card` writes a [`Card`] as JSON. The committed cards in `docs/cards` are summarised
//! in `docs/cards.md`.

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
