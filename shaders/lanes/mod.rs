//! Lookups of many receivers at once on the CPU, in vector lanes. Kernels of map techniques pass
//! their span to [`look_up_span`](batch::look_up_span). They implement
//! [`BatchTaps`](batch::BatchTaps) for a whole batch of receivers, or [`Taps`](batch::Taps) for one
//! receiver, which is slower.

pub mod batch;
#[cfg(test)]
pub(crate) mod fixtures;
pub(crate) mod single;
pub mod square;
pub(crate) mod whole;
