//! Hierarchies of casters that the device builds, for kernels that read them
//! ([`DeviceHierarchy`](umbrage_core::DeviceHierarchy)).

pub(crate) mod layout;
pub(crate) mod one;
pub(crate) mod passes;
mod sort;
