//! Compares the triangles that a backend sees with those of truth.

use crate::error::LabError;
use umbrage_core::{
    Backend, Camera, Geometry, Light, Receivers, Shadows, Snapping, View, metrics::Pixel,
};
use umbrage_cpu::{Cpu, CpuOptions};
use umbrage_plan::truth::{Truth, TruthOptions, ambiguous_on};

/// Camera, light and triangles of a scene, without receivers.
#[derive(Clone, Copy)]
pub(super) struct SceneView<'a> {
    pub(super) camera: &'a Camera,
    pub(super) light: &'a Light,
    pub(super) geometry: &'a Geometry,
}

impl<'a> SceneView<'a> {
    /// Converts it to the type of core.
    pub(super) fn core(&self) -> View<'a> {
        View::new(self.camera, self.light, self.geometry)
    }
}

/// The view of a scene by a backend.
#[derive(Debug)]
pub(super) struct SeenByBackend {
    /// The visible receivers.
    pub(super) receivers: Receivers,
    /// Classes of pixels. `None` if they equal truth's.
    ///
    /// They differ at pixels where the backend sees another triangle, and where its sub-pixel grid
    /// makes truth ambiguous.
    pub(super) pixels: Option<Vec<Pixel>>,
}

/// Maximum share of pixels that show another triangle than expected.
///
/// Devices that don't round vertices to nearest move edges by up to half a step more. If triangles
/// are as small as pixels, many pixels then show a neighbour.
const MAX_OTHER_IDS: f64 = 0.05;
/// Maximum share of pixels that show a surface at another distance. This only happens at outlines.
const MAX_OTHER_SURFACES: f64 = 0.001;
/// Relative difference of distances from the eye below which surfaces are the same.
const MAX_DISTANCE_DIFFERENCE: f32 = 0.01;

impl SeenByBackend {
    /// Checks the triangles that a backend saw.
    ///
    /// They may differ from truth's only as its vertex rounding explains: the CPU must see the same
    /// triangles with this rounding.
    pub(super) fn new(
        scene: &str,
        view: &SceneView<'_>,
        truth: &Truth,
        options: &TruthOptions,
        backend: &dyn Backend,
        shadows: &Shadows,
    ) -> Result<Self, LabError> {
        let kind = backend.kind();
        if view.geometry.fingerprint() != truth.fingerprint {
            return Err(not_comparable(
                scene,
                "truth was traced with other triangles",
            ));
        }
        let Some(seen) = &shadows.receivers else {
            let what = format!("backend {kind} doesn't report its receivers");
            return Err(not_comparable(scene, what));
        };
        if seen.size != truth.size {
            let what = format!(
                "backend {kind} sees an image of {}, truth one of {}",
                seen.size, truth.size
            );
            return Err(not_comparable(scene, what));
        }
        let rounded;
        let expected = if backend.snapping() == Snapping::default() {
            &truth.receivers
        } else {
            let options = CpuOptions::default().snapping(backend.snapping());
            rounded = Cpu::with_options(&options)?.receivers(view.camera, view.geometry)?;
            &rounded
        };
        let Differences { ids, surfaces } = differences(expected, seen);
        let of = truth.pixels.len();
        let has_other_ids = ids as f64 > MAX_OTHER_IDS * of as f64;
        let has_other_surfaces = surfaces as f64 > MAX_OTHER_SURFACES * of as f64;
        if has_other_ids || has_other_surfaces {
            let rule = backend.snapping();
            let what = format!(
                "truth and backend {kind} see different triangles at {ids} of {of} pixels, {surfaces} of them at other distances, even with {rule}"
            );
            return Err(not_comparable(scene, what));
        }
        let ambiguous = ambiguous_on(
            backend.snapping().step(),
            view.camera,
            view.light,
            view.geometry,
            truth,
            options,
            &mut |camera, geometry| Cpu::new().receivers(camera, geometry),
        )?;
        Ok(Self {
            receivers: seen.clone(),
            pixels: classes(truth, seen, ambiguous.as_deref()),
        })
    }
}

fn not_comparable(scene: &str, what: impl Into<String>) -> LabError {
    LabError::NotComparable {
        scene: scene.to_owned(),
        what: what.into(),
    }
}

/// Returns truth's classes of pixels, changed where the backend sees other triangles and where
/// `ambiguous` is set. `None` if nothing changes.
fn classes(truth: &Truth, seen: &Receivers, ambiguous: Option<&[bool]>) -> Option<Vec<Pixel>> {
    let expected = &truth.receivers;
    if ambiguous.is_none() && expected.triangle == seen.triangle {
        return None;
    }
    let mut out = Vec::with_capacity(truth.pixels.len());
    for (i, &class) in truth.pixels.iter().enumerate() {
        let is_ambiguous = ambiguous.is_some_and(|ambiguous| ambiguous[i]);
        out.push(match class {
            Pixel::Empty => Pixel::Empty,
            _ if expected.triangle[i] != seen.triangle[i] => Pixel::Elsewhere,
            Pixel::Counted if is_ambiguous => Pixel::Ambiguous,
            class => class,
        });
    }
    Some(out)
}

/// Number of different pixels in two images of the same view.
struct Differences {
    /// Pixels that show different triangles.
    ids: usize,
    /// Those of them with different distances, too: their triangles are not neighbours on a
    /// surface.
    surfaces: usize,
}

fn differences(a: &Receivers, b: &Receivers) -> Differences {
    let mut out = Differences {
        ids: 0,
        surfaces: 0,
    };
    for i in (0..a.len()).filter(|&i| a.triangle[i] != b.triangle[i]) {
        let difference = (a.distance[i] - b.distance[i]).abs();
        let is_elsewhere = difference > MAX_DISTANCE_DIFFERENCE * a.distance[i];
        out.ids += 1;
        out.surfaces += usize::from(is_elsewhere);
    }
    out
}
