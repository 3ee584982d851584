//! Figures of both sides for the current view: measured at rest, and discarded after a change.

use super::{
    cost::Cost,
    pictures::{self, Picture},
    subject::Subject,
    truth::{self, Tracing, TruthSoFar},
};
use crate::{
    job::Job,
    render::{
        Renderer,
        mask::{PendingMask, ReceiverTextures},
    },
    settings::Settings,
};
use anyhow::Result;
use umbrage::metrics::Pixel;

/// Errors of a mask over the evaluated pixels that are traced.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct MaskError {
    /// Root of the mean square.
    pub rmse: f64,
    /// Number of pixels with an error of more than a sixteenth.
    pub wrong: usize,
    /// Number of evaluated pixels.
    pub pixels: usize,
    /// Number of pixels excluded because the reference depends on rounding. `None` before that is
    /// known.
    pub ambiguous: Option<usize>,
}

/// Compares a mask with the reference.
fn mask_error(truth: &TruthSoFar, mask: &[f32]) -> MaskError {
    let mut out = MaskError::default();
    let mut ambiguous = 0;
    let mut squares = 0.0;
    for (i, pixel) in truth.pixels.iter().enumerate() {
        match pixel {
            Pixel::Counted => {
                let off = f64::from(mask[i] - truth.visibility[i]);
                squares += off * off;
                out.wrong += usize::from(off.abs() > 1.0 / 16.0);
                out.pixels += 1;
            }
            Pixel::Ambiguous => ambiguous += 1,
            _ => {}
        }
    }
    out.rmse = (squares / out.pixels.max(1) as f64).sqrt();
    out.ambiguous = truth.is_checked.then_some(ambiguous);
    out
}

/// An image of lookups.
struct LookupPicture {
    kind: Picture,
    /// The job, until the image is done.
    job: Option<Job<Option<Vec<u8>>>>,
    /// sRGB and opacity, a byte each. `None` before the image is done, and if there is nothing to
    /// show.
    rgba: Option<Vec<u8>>,
}

/// Figures of a side.
#[derive(Default)]
pub(crate) struct SideFigures {
    pending: Option<PendingMask>,
    pub mask: Option<Vec<f32>>,
    pub error: Option<MaskError>,
    pub cost: Option<Cost>,
    /// Time of the mask's lookups on the device, milliseconds; `None` without timestamps, and on
    /// software adapters.
    pub lookup_ms: Option<f64>,
    /// Reason why the light has no shadows on this side, and therefore no figures.
    pub refusal: Option<String>,
    lookups: Option<LookupPicture>,
}

impl SideFigures {
    /// Reports whether the side's lookups are being timed.
    fn times_lookups(&self) -> bool {
        let heat = self.lookups.as_ref();
        heat.is_some_and(|lookups| lookups.kind == Picture::Heat && lookups.job.is_some())
    }
}

/// Figures of both sides.
#[derive(Default)]
pub(crate) struct ViewFigures {
    /// The measured subject.
    pub subject: Option<Subject>,
    tracing: Option<Tracing>,
    receivers: Option<ReceiverTextures>,
    pub truth: Option<TruthSoFar>,
    pub sides: [SideFigures; 2],
}

impl ViewFigures {
    /// Reports whether the reference is complete, and both sides have their masks or no shadows.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn is_complete(&self) -> bool {
        let is_known = |side: &SideFigures| side.mask.is_some() || side.refusal.is_some();
        self.truth.as_ref().is_some_and(|truth| truth.is_checked) && self.sides.iter().all(is_known)
    }

    /// Reports whether the device is computing masks.
    pub(crate) fn is_waiting(&self) -> bool {
        self.sides.iter().any(|side| side.pending.is_some())
    }

    /// Discards all figures.
    pub(crate) fn forget(&mut self, renderer: &mut Renderer) {
        *self = Self::default();
        renderer.show_overlay(0, None);
        renderer.show_overlay(1, None);
    }

    /// Discards a side's figures, since its technique changed.
    pub(crate) fn forget_side(&mut self, side: usize, renderer: &mut Renderer) {
        self.sides[side] = SideFigures::default();
        renderer.show_overlay(side, None);
    }

    /// Starts measurements at rest, and receives results. Returns whether there are new ones.
    ///
    /// # Errors
    /// Returns an error if the light is not valid, or the device fails.
    pub(crate) fn update(
        &mut self,
        ctx: &egui::Context,
        renderer: &mut Renderer,
        settings: &Settings,
        subject: &Subject,
        rests: bool,
    ) -> Result<bool> {
        if self.subject.as_ref() != Some(subject) {
            self.forget(renderer);
            if rests {
                self.tracing = Some(truth::start(ctx, subject.clone()));
                self.subject = Some(subject.clone());
            }
            return Ok(false);
        }
        let mut is_new = false;
        if let Some(truth) = self.tracing.as_mut().and_then(Tracing::take) {
            let truth = truth?;
            self.receivers
                .get_or_insert_with(|| renderer.upload_receivers(&truth.receivers));
            self.truth = Some(truth);
            is_new = true;
        }
        is_new |= self.fetch_masks(renderer, settings, subject, rests)?;
        is_new |= self.take_lookups()?;
        Ok(is_new)
    }

    /// Receives images of lookups. Returns whether there is a new one.
    fn take_lookups(&mut self) -> Result<bool> {
        let mut is_new = false;
        for lookups in self.sides.iter_mut().flat_map(|side| &mut side.lookups) {
            if let Some(rgba) = lookups.job.as_mut().and_then(Job::take) {
                lookups.job = None;
                lookups.rgba = rgba?;
                is_new = true;
            }
        }
        Ok(is_new)
    }

    /// Requests masks of the sides that were prepared for the subject, and receives masks. Returns
    /// whether there is a new one.
    fn fetch_masks(
        &mut self,
        renderer: &mut Renderer,
        settings: &Settings,
        subject: &Subject,
        rests: bool,
    ) -> Result<bool> {
        let Some(receivers) = &self.receivers else {
            return Ok(false);
        };
        let before = settings.lights.iter().take(settings.chosen);
        let nth_light = before.filter(|light| light.is_on).count();
        let mut is_new = false;
        for (i, figures) in self.sides.iter_mut().enumerate() {
            if let Some(pending) = &figures.pending {
                if let Some((mask, milliseconds)) = pending.take()? {
                    figures.mask = Some(mask);
                    figures.lookup_ms = milliseconds;
                    figures.pending = None;
                    is_new = true;
                }
                continue;
            }
            let is_ready = rests && renderer.sides[i].is_ready_for(&subject.camera, settings, i);
            if !is_ready || figures.mask.is_some() || figures.refusal.is_some() {
                continue;
            }
            let Some(&light) = renderer.sides[i].ids.get(nth_light) else {
                continue;
            };
            // Skip a light without shadows: a fully lit mask is no result of the technique.
            figures.refusal = renderer.sides[i].refusal(light);
            if figures.refusal.is_some() {
                is_new = true;
            } else {
                figures.pending = Some(renderer.request_mask(i, light, receivers)?);
            }
        }
        renderer.poll()?;
        Ok(is_new)
    }

    /// Compares masks with the reference, and updates the overlays of the sides.
    pub(crate) fn compare(
        &mut self,
        ctx: &egui::Context,
        renderer: &mut Renderer,
        settings: &Settings,
    ) {
        let (Some(truth), Some(subject)) = (&self.truth, &self.subject) else {
            return;
        };
        // Time one side after the other, since each uses all cores.
        let mut is_timing = self.sides.iter().any(SideFigures::times_lookups);
        for (i, side) in self.sides.iter_mut().enumerate() {
            let mask = side.mask.as_deref();
            side.error = mask.map(|mask| mask_error(truth, mask));
            let preset = settings.sides[i].preset_for(&subject.light);
            if side.cost.is_none() && mask.is_some() {
                match Cost::of_settings(&preset, subject, &truth.receivers) {
                    Ok(cost) => side.cost = Some(cost),
                    Err(error) => side.refusal = Some(format!("{error:#}")),
                }
            }
            let kind = settings.picture;
            if !kind.is_of_lookups() {
                let rgba = pictures::of_mask(kind, truth, mask);
                renderer.show_overlay(i, rgba.map(|rgba| (truth.receivers.size, rgba)));
                continue;
            }
            // Wait for tracing, which uses all cores, too.
            let must_wait = kind == Picture::Heat && (is_timing || !truth.is_checked);
            let is_known = side
                .lookups
                .as_ref()
                .is_some_and(|known| known.kind == kind);
            if side.refusal.is_none() && !is_known && !must_wait {
                is_timing |= kind == Picture::Heat;
                let technique = preset.technique();
                let (subject, receivers) = (subject.clone(), truth.receivers.clone());
                let job = Job::start(ctx, move |_| {
                    pictures::of_lookups(kind, &*technique, &subject, &receivers).map(Some)
                });
                side.lookups = Some(LookupPicture {
                    kind,
                    job: Some(job),
                    rgba: None,
                });
            }
            let shown = side
                .lookups
                .as_ref()
                .filter(|lookups| lookups.kind == kind && side.refusal.is_none());
            let rgba = shown.and_then(|lookups| lookups.rgba.clone());
            renderer.show_overlay(i, rgba.map(|rgba| (truth.receivers.size, rgba)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_mask_has_no_error_and_another_has() {
        let truth = TruthSoFar::of_test();
        let same = mask_error(&truth, &[0.0, 1.0, 0.5, 0.0]);
        assert_eq!((same.rmse, same.wrong, same.pixels), (0.0, 0, 3));
        let other = mask_error(&truth, &[1.0, 1.0, 0.5, 0.0]);
        assert!((other.rmse - (1.0_f64 / 3.0).sqrt()).abs() < 1e-9);
        assert_eq!(other.wrong, 1);
    }

    #[test]
    fn ambiguous_pixels_count_in_no_error() {
        let mut truth = TruthSoFar::of_test();
        truth.pixels[0] = Pixel::Ambiguous;
        truth.is_checked = true;
        let mask = [1.0, 1.0, 0.5, 0.0];
        let error = mask_error(&truth, &mask);
        assert_eq!(
            (error.rmse, error.pixels, error.ambiguous),
            (0.0, 2, Some(1))
        );
        let over = pictures::of_mask(Picture::Error, &truth, Some(&mask)).expect("there");
        assert_eq!(over[3], 0);
    }
}
