//! Lookups of many receivers at once on the CPU, in vector lanes. Kernels of a map technique hand their span to
//! [`look_up_span`](batch::look_up_span) and say with [`Taps`](batch::Taps) what they make of one receiver's place on the map.

pub mod batch;
pub(crate) mod single;
pub mod square;
