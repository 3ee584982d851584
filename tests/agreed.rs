//! Comparison of a device's mask with the CPU's.

use umbrage_core::{Backend, Recipe, Shadows, View, metrics::Agreement};
use umbrage_lab::compare;
use umbrage_wgpu::Gpu;

/// Compares a device's mask with the CPU's: bit by bit on the pinned driver, elsewhere in decided
/// pixels.
///
/// # Errors
/// Returns an error that names the recipe as `label` if they differ.
pub fn check_agreement(
    gpu: &Gpu,
    label: &str,
    view: &View<'_>,
    recipe: &Recipe,
    of_cpu: &Shadows,
    of_gpu: &Shadows,
) -> Result<Agreement, String> {
    let agreement = compare::agree(view, recipe, of_cpu, of_gpu, gpu.snapping())
        .map_err(|why| format!("{label}: {why}"))?;
    let agrees = if gpu.promises_bits() {
        agreement.differing == 0
    } else {
        agreement.holds()
    };
    if agrees {
        Ok(agreement)
    } else {
        Err(format!("{label}: {agreement:?}"))
    }
}
