//! What is measured and planned of `pcf_dithered`.

use super::{CataloguedTechnique, sweeps};
use umbrage_core::Fit;
use umbrage_techniques::PcfDithered;

impl CataloguedTechnique for PcfDithered {
    fn compared(map_sizes: &[u32], fit: Fit) -> Vec<Self> {
        sweeps::sweep(map_sizes, fit, &sweeps::two_biases(1.5), |map| Self { map })
    }

    const RANDOM_WEIGHT: u32 = 2;
}
