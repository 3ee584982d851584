//! Which triangles a backend sees, and where truth saw others.

use super::scene::View3;
use crate::LabError;
use umbrage_core::{Backend, Camera, Geometry, Receivers, Shadows, Snapping, metrics::Pixel};
use umbrage_cpu::{Cpu, CpuOptions};
use umbrage_plan::truth::{Truth, TruthOptions, ambiguous_on};

/// What a backend sees of a scene.
#[derive(Debug)]
pub(super) struct SeenByBackend {
    triangle: Vec<u32>,
    /// What counts: truth's classes but for pixels at which the backend sees another triangle, and those that its grid of
    /// sub-pixels makes ambiguous; none if there are neither.
    pub(super) pixels: Option<Vec<Pixel>>,
}

/// Rounding of another kind than nearest moves edges by half a step more: where triangles are as small as pixels, this share
/// of the pixels may show a neighbour ...
const MAX_OTHER_IDS: f64 = 0.05;
/// ... but on outlines alone may it lie elsewhere.
const MAX_OTHER_SURFACES: f64 = 0.001;

impl SeenByBackend {
    /// Looks at what a backend saw. It may be other triangles than truth's, but only those that the rounding of its device's
    /// vertices explains: the CPU must see them, too, when it rounds so.
    pub(super) fn new(
        scene: &str,
        view: &View3<'_>,
        truth: &Truth,
        options: &TruthOptions,
        backend: &dyn Backend,
        shadows: &Shadows,
    ) -> Result<Self, LabError> {
        let fault = |what: String| LabError::NotComparable {
            scene: scene.to_owned(),
            what,
        };
        let kind = backend.kind();
        if view.geometry.fingerprint() != truth.fingerprint {
            return Err(fault("truth was traced with other triangles".to_owned()));
        }
        let Some(seen) = &shadows.receivers else {
            return Err(fault(format!(
                "backend {kind} doesn't tell which receivers it saw"
            )));
        };
        if seen.size != truth.size {
            return Err(fault(format!(
                "backend {kind} sees an image of {}, truth one of {}",
                seen.size, truth.size
            )));
        }
        let rounded;
        let expected = if backend.snapping() == Snapping::default() {
            &truth.receivers
        } else {
            let options = CpuOptions::default().snapping(backend.snapping());
            rounded = Cpu::with_options(&options)?.receivers(view.camera, view.geometry)?;
            &rounded
        };
        let ([ids, surfaces], of) = (different(expected, seen), truth.pixels.len());
        if ids as f64 > MAX_OTHER_IDS * of as f64
            || surfaces as f64 > MAX_OTHER_SURFACES * of as f64
        {
            let rule = backend.snapping();
            let what = format!(
                "truth and backend {kind} see other triangles at {ids} of {of} pixels, {surfaces} far off, even with {rule}"
            );
            return Err(fault(what));
        }
        let view = (view.camera, view.light, view.geometry);
        let find =
            &mut |camera: &Camera, geometry: &Geometry| Cpu::new().receivers(camera, geometry);
        let ambiguous = ambiguous_on(backend.snapping().step(), view, truth, options, find)?;
        Ok(Self {
            triangle: seen.triangle.clone(),
            pixels: classes(truth, seen, ambiguous.as_deref()),
        })
    }

    /// Whether a later rendering shows the same triangles.
    pub(super) fn holds(&self, shadows: &Shadows) -> bool {
        shadows
            .receivers
            .as_ref()
            .is_some_and(|seen| seen.triangle == self.triangle)
    }
}

/// Truth's classes of pixels, but for those at which other triangles are seen and these ambiguous ones; none if there are none.
fn classes(truth: &Truth, seen: &Receivers, ambiguous: Option<&[bool]>) -> Option<Vec<Pixel>> {
    let same = |i: usize| truth.receivers.triangle[i] == seen.triangle[i];
    let class = |i: usize| match truth.pixels[i] {
        Pixel::Empty => Pixel::Empty,
        _ if !same(i) => Pixel::Elsewhere,
        Pixel::Counted if ambiguous.is_some_and(|ambiguous| ambiguous[i]) => Pixel::Ambiguous,
        class => class,
    };
    let of = truth.pixels.len();
    (ambiguous.is_some() || !(0..of).all(same)).then(|| (0..of).map(class).collect())
}

/// At how many pixels the triangles differ, and at how many their distances do by over a hundredth, too.
fn different(a: &Receivers, b: &Receivers) -> [usize; 2] {
    let ids = (0..a.len()).filter(|&i| a.triangle[i] != b.triangle[i]);
    let far = |i: &usize| (a.distance[*i] - b.distance[*i]).abs() > 0.01 * a.distance[*i];
    [ids.clone().count(), ids.filter(far).count()]
}
