//! What a frame of a set took.

/// What [`LightSet::prepare`](crate::LightSet::prepare) found to do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SetReport {
    /// Lights that were planned.
    pub planned: u32,
    /// Layers that this frame draws.
    pub redrawn: u32,
    /// Lights whose lists of casters this frame makes.
    pub listed: u32,
    /// Layers that wait for one of the next frames, as [`SetBudget::redraws`](crate::SetBudget::redraws) asks.
    pub waiting: u32,
    /// Bytes written to the GPU.
    pub uploaded: u64,
}
