//! A faulty second backend, for tests of fault detection.

use umbrage_core::{Backend, BackendError, Recipe, Shadows, Snapping, View};
use umbrage_cpu::{Cpu, CpuOptions};

/// The CPU backend under wgpu's name. `spoil` changes its results.
pub(crate) struct FaultyBackend<F> {
    cpu: Cpu,
    spoil: F,
    says: Snapping,
}

impl<F: FnMut(&mut Shadows)> FaultyBackend<F> {
    pub(crate) fn new(spoil: F) -> Self {
        Self {
            cpu: Cpu::new(),
            spoil,
            says: Snapping::default(),
        }
    }

    /// Returns a backend that rounds vertices as `does`, but reports `says`.
    pub(crate) fn rounding(does: Snapping, says: Snapping, spoil: F) -> Self {
        let cpu =
            Cpu::with_options(&CpuOptions::default().snapping(does)).expect("a known rounding");
        Self { cpu, spoil, says }
    }
}

impl<F: FnMut(&mut Shadows)> Backend for FaultyBackend<F> {
    fn name(&self) -> &str {
        "a faulty backend"
    }
    fn kind(&self) -> &'static str {
        "wgpu"
    }
    fn snapping(&self) -> Snapping {
        self.says
    }
    fn render(&mut self, view: &View<'_>, recipe: &Recipe) -> Result<Shadows, BackendError> {
        let mut shadows = self.cpu.render(view, recipe)?;
        (self.spoil)(&mut shadows);
        Ok(shadows)
    }
}

/// Lightens the last of the darkest pixels in penumbrae.
pub(crate) fn lighten_one(shadows: &mut Shadows) {
    let lit = |v: f32| if v > 0.0 { v } else { 1.0 };
    let values = shadows.mask.iter_mut();
    let darkest = values.min_by(|a, b| lit(**a).total_cmp(&lit(**b)));
    *darkest.expect("a pixel is visible") = 1.0;
}

/// Darkens the last pixel that is fully lit.
pub(crate) fn darken_one(shadows: &mut Shadows) {
    let lit = shadows
        .mask
        .iter()
        .rposition(|v| *v == 1.0)
        .expect("something is lit");
    shadows.mask[lit] = 0.0;
}
