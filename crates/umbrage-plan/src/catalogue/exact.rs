//! Catalogue entry of `exact`.

use super::{
    Candidate, CataloguedTechnique, ClosedFormDemand,
    kernel::{self, CataloguedKernel, KernelCost},
};
use umbrage_core::{Fit, Light, ReceiveKernel, Receivers, Recipe};
use umbrage_techniques::{Exact, ExactKernel, ExactStructure, HierarchyKernel, ShadowMap};

const STRUCTURES: [ExactStructure; 2] = [ExactStructure::Lists, ExactStructure::Hierarchy];

impl CataloguedTechnique for Exact {
    fn kernel(kernel: &dyn ReceiveKernel) -> Option<&dyn CataloguedKernel> {
        kernel::downcast::<ExactKernel>(kernel)
            .or_else(|| kernel::downcast::<HierarchyKernel>(kernel))
    }

    fn compared_settings(_: &[u32], _: Fit) -> Vec<Self> {
        STRUCTURES.map(|structure| Self { structure }).to_vec()
    }

    fn headline(map_sizes: &[u32], fit: Fit) -> Vec<Self> {
        Self::compared_settings(map_sizes, fit)
    }

    fn exhaustive(_: u32) -> Vec<Self> {
        STRUCTURES.map(|structure| Self { structure }).to_vec()
    }

    fn candidates(_: ShadowMap, _: &Light) -> Vec<Candidate<Self>> {
        let setting = |structure| Candidate::from_setting(Self { structure });
        STRUCTURES.map(setting).to_vec()
    }

    fn why_chosen(&self, _: f64, _: &Recipe) -> Option<String> {
        Some("its result is that of ray tracing, without a map or a bias".to_owned())
    }

    fn closed_form(_: ShadowMap) -> Option<ClosedFormDemand<Self>> {
        Some(ClosedFormDemand::new(Self::default(), 0.0))
    }

    fn random(map: ShadowMap, _: &[f32]) -> Self {
        // Another random number would change all later cases of a seed.
        Self {
            structure: STRUCTURES[map.size as usize % 2],
        }
    }
}

impl CataloguedKernel for ExactKernel {
    /// Counts a cell, and some of the casters in its list.
    fn cost_per_receiver(&self) -> KernelCost {
        KernelCost::taps(taps_from_memory(self).ceil() as u32)
    }

    fn cost_for(&self, receivers: &Receivers) -> KernelCost {
        let taps = taps_from_memory(self).max(self.mean_list_length(receivers));
        KernelCost::taps(taps.ceil() as u32)
    }

    fn triangles_listed(&self) -> u64 {
        Self::triangles_listed(self)
    }
}

impl CataloguedKernel for HierarchyKernel {
    fn cost_per_receiver(&self) -> KernelCost {
        KernelCost::walks(1)
    }
}

/// Divisor of the square root of the number of casters for the taps of a lookup.
///
/// With more casters, a larger part of the lists is outside the caches. The cost is the maximum of
/// this and one tap per caster in the list. In six frames with 164 thousand to 2.4 million casters,
/// it is within a factor of 1.45 of measured lookups on the CPU and on lavapipe. The exception is
/// `valley` on the CPU, where it is 1.7 times too high.
const CASTERS_A_TAP: f32 = 30.0;

/// Returns the taps of a lookup whose lists are outside the caches.
fn taps_from_memory(kernel: &ExactKernel) -> f32 {
    (kernel.casters() as f32).sqrt() / CASTERS_A_TAP
}
