//! Measured properties of kernels: their costs and their reach.

use std::any::Any;
use umbrage_core::{ReceiveKernel, Receivers, glam::Vec3};

/// Receive kernel with measured properties.
///
/// Each item has a default: an unknown kernel costs one tap.
pub trait CataloguedKernel: Sync {
    /// Returns the greatest cost for one receiver. [`Work`](crate::cost::Work) uses it for the
    /// price of a technique.
    fn cost_per_receiver(&self) -> KernelCost {
        KernelCost::default()
    }

    /// Returns the cost for these receivers, if it depends on them.
    fn cost_for(&self, receivers: &Receivers) -> KernelCost {
        let _ = receivers;
        self.cost_per_receiver()
    }

    /// Returns the number of triangles in its tables, including repetitions. Tables that follow the
    /// light or the casters are rebuilt with them, at about the CPU's cost of drawing as many triangles.
    fn triangles_listed(&self) -> u64 {
        0
    }

    /// Returns the greatest error, 0..=1, of its visibility without casters, if the light has an
    /// extent. The kernel must then return the share of the light above the receiver's tangent
    /// plane. Returns `None` for kernels that treat the light as its centre, or sample single
    /// points of it.
    fn horizon_error(&self) -> Option<f32> {
        None
    }

    /// Returns the reach, in texels, of a lookup beyond the receiver's point on the map, if it
    /// differs between receivers. `position` is in world space, `normal` is a unit vector. Returns
    /// `None` if [`CataloguedTechnique::kernel_reach`](super::CataloguedTechnique::kernel_reach)
    /// applies.
    fn reach(&self, position: Vec3, normal: Vec3) -> Option<f32> {
        let _ = (position, normal);
        None
    }

    /// Returns the layer of its map in which a receiver at `position` (world space) is looked up,
    /// if there are several. Returns `None` if the layers are the faces of a cube, so that the
    /// receiver's face is used.
    fn layer(&self, position: Vec3) -> Option<u32> {
        let _ = position;
        None
    }
}

/// Greatest cost of a kernel for one receiver.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct KernelCost {
    /// Texels loaded. In the rows of a square of texels, three neighbours count as one.
    pub taps: u32,
    /// Comparison samples, each of four texels.
    pub samples: u32,
    /// Rays traced.
    pub rays: u32,
    /// Walks through a hierarchy that the device builds.
    pub walks: u32,
}

impl Default for KernelCost {
    /// Returns one tap.
    fn default() -> Self {
        Self::taps(1)
    }
}

impl KernelCost {
    const NOTHING: Self = Self {
        taps: 0,
        samples: 0,
        rays: 0,
        walks: 0,
    };

    /// Returns a cost of taps only.
    pub const fn taps(taps: u32) -> Self {
        Self {
            taps,
            ..Self::NOTHING
        }
    }

    /// Returns a cost of comparison samples only.
    pub const fn samples(samples: u32) -> Self {
        Self {
            samples,
            ..Self::NOTHING
        }
    }

    /// Returns a cost of rays only.
    pub const fn rays(rays: u32) -> Self {
        Self {
            rays,
            ..Self::NOTHING
        }
    }

    /// Returns a cost of walks only.
    pub const fn walks(walks: u32) -> Self {
        Self {
            walks,
            ..Self::NOTHING
        }
    }
}

/// Kernel without measured properties.
#[derive(Clone, Copy, Debug)]
pub(super) struct UnknownKernel;

impl CataloguedKernel for UnknownKernel {}

/// Returns the measured properties of `kernel`, if it is a `K`.
pub fn downcast<K: CataloguedKernel + ReceiveKernel>(
    kernel: &dyn ReceiveKernel,
) -> Option<&dyn CataloguedKernel> {
    let kernel: &dyn Any = kernel;
    Some(kernel.downcast_ref::<K>()?)
}
