//! Lookups of many receivers at once on the CPU, in vector lanes. Kernels of a map technique hand
//! their span to [`look_up_span`](batch::look_up_span) and say what they make of the places of many
//! receivers on the map ([`BatchTaps`](batch::BatchTaps)), or of one receiver's
//! ([`Taps`](batch::Taps)), which takes longer.

pub mod batch;
#[cfg(test)]
pub(crate) mod fixtures;
pub(crate) mod single;
pub mod square;
pub(crate) mod whole;
