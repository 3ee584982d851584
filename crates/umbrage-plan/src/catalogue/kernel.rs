//! What is measured of kernels: what they cost, and how far they look.

use std::any::Any;
use umbrage_core::{ReceiveKernel, Receivers, glam::Vec3};

/// A receive kernel that is measured.
///
/// Each item has a default: a kernel of which nothing is known costs one tap.
pub trait CataloguedKernel: Sync {
    /// Returns what it does for one receiver, at most: for [`Work`](crate::cost::Work), which the
    /// price of a technique is made of.
    fn cost_per_receiver(&self) -> KernelCost {
        KernelCost::default()
    }

    /// Returns the same for these receivers, if it depends on them.
    fn cost_for(&self, receivers: &Receivers) -> KernelCost {
        let _ = receivers;
        self.cost_per_receiver()
    }

    /// Returns how many triangles its tables were made of, each as often as it stands in them:
    /// tables that follow the light or the casters are rebuilt with them. That costs about as much
    /// as drawing as many triangles.
    fn triangles_listed(&self) -> u64 {
        0
    }

    /// Returns by how much its answer may be wrong where nothing casts, 0..=1, if it answers the
    /// share of a light with an extent that the receiver's own tangent plane leaves. `None` of
    /// kernels that take the light for its middle, or query single points of it.
    fn horizon_error(&self) -> Option<f32> {
        None
    }

    /// Returns how far, in texels, the lookup of a receiver at `position` (world space) with the
    /// unit `normal` goes beyond the point of the map on which it falls, if that differs from one
    /// receiver to the next. `None`: as far as
    /// [`CataloguedTechnique::kernel_reach`](super::CataloguedTechnique::kernel_reach) returns.
    fn reach(&self, position: Vec3, normal: Vec3) -> Option<f32> {
        let _ = (position, normal);
        None
    }

    /// Returns the layer of its map in which a receiver at `position` (world space) is looked up,
    /// if there are several. `None`: the layers are the faces of a cube, and it is that of the face
    /// in which the receiver lies.
    fn layer(&self, position: Vec3) -> Option<u32> {
        let _ = position;
        None
    }
}

/// What a kernel reads for one receiver, at most.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct KernelCost {
    /// Texels loaded; of the rows of a square of texels, each three neighbours as one.
    pub taps: u32,
    /// Comparison samples taken, each of four texels.
    pub samples: u32,
    /// Rays traced.
    pub rays: u32,
}

impl Default for KernelCost {
    /// One tap.
    fn default() -> Self {
        Self::taps(1)
    }
}

impl KernelCost {
    /// Taps alone.
    pub const fn taps(taps: u32) -> Self {
        Self {
            taps,
            samples: 0,
            rays: 0,
        }
    }

    /// Comparison samples alone.
    pub const fn samples(samples: u32) -> Self {
        Self {
            taps: 0,
            samples,
            rays: 0,
        }
    }

    /// Rays alone.
    pub const fn rays(rays: u32) -> Self {
        Self {
            taps: 0,
            samples: 0,
            rays,
        }
    }
}

/// A kernel of which nothing is known.
#[derive(Clone, Copy, Debug)]
pub(super) struct UnknownKernel;

impl CataloguedKernel for UnknownKernel {}

/// Returns `kernel` as what is measured of it, if it is a `K`.
pub fn downcast<K: CataloguedKernel + ReceiveKernel>(
    kernel: &dyn ReceiveKernel,
) -> Option<&dyn CataloguedKernel> {
    let kernel: &dyn Any = kernel;
    Some(kernel.downcast_ref::<K>()?)
}
