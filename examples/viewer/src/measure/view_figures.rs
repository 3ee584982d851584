//! The errors of both sides at the present view: asked for when nothing moves, and forgotten when something does.

use super::{
    cost::Cost,
    figures::{self, MaskError, Picture},
    places::{self, Places, SeenFrom},
    truth::{TruthRequest, TruthSoFar},
    worker::{News, Worker},
};
use crate::{
    beside::Beside,
    render::{
        Renderer,
        mask::{PendingMask, ReceiverTextures},
    },
    settings::SideSettings,
};
use anyhow::Result;
use eframe::egui_wgpu::RenderState;
use std::sync::Arc;
use umbrage::{Camera, Geometry, Light};

/// Rays for each pixel of lights with an extent.
const TRUTH_RAYS: u32 = 256;

/// What is known of a side.
#[derive(Default)]
pub(crate) struct SideFigures {
    pending: Option<PendingMask>,
    pub mask: Option<Vec<f32>>,
    pub error: Option<MaskError>,
    pub cost: Option<Cost>,
    /// What the mask's lookups took on the device, milliseconds; none where that has no clock.
    pub lookup_ms: Option<f64>,
    /// Why the light has no shadows on this side, and so no figures; none if it has.
    pub refusal: Option<String>,
    places: Option<PlacesPicture>,
}

/// A picture of where lookups go. It hangs on the camera, the light and the settings, and not on truth.
struct PlacesPicture {
    kind: Places,
    job: Beside<Option<Vec<u8>>>,
    /// sRGB and opacity, a byte each; none before it is there, and if there is nothing of that kind.
    rgba: Option<Vec<u8>>,
    is_under_way: bool,
}

impl SideFigures {
    /// Whether the side's lookups are being timed.
    fn times_lookups(&self) -> bool {
        let places = self.places.as_ref();
        places.is_some_and(|places| places.kind == Places::Heat && places.is_under_way)
    }
}

/// What is laid over the picture, and how densely.
pub(crate) struct ShownFigures {
    pub picture: Picture,
    pub opacity: f32,
}

/// What is to be measured.
pub(crate) struct Question<'a> {
    pub camera: Camera,
    pub light: Light,
    /// Index of the light among those that are on.
    pub place: usize,
    pub geometry: &'a Geometry,
}

/// What figures are of; with anything else they are stale.
#[derive(Clone, PartialEq)]
struct MeasuredFor {
    camera: Camera,
    light: Light,
    scene: u64,
}

pub(crate) struct ViewFigures {
    worker: Worker,
    /// Counted up with each question for truth.
    asked: u64,
    measured_for: Option<MeasuredFor>,
    receivers: Option<ReceiverTextures>,
    pub truth: Option<Box<TruthSoFar>>,
    pub sides: [SideFigures; 2],
    wake: Arc<dyn Fn() + Send + Sync>,
}

impl ViewFigures {
    /// `wake` is called when there is news.
    pub(crate) fn new(wake: impl Fn() + Send + Sync + 'static) -> Self {
        let wake: Arc<dyn Fn() + Send + Sync> = Arc::new(wake);
        let of_worker = wake.clone();
        Self {
            worker: Worker::new(move || of_worker()),
            wake,
            asked: 0,
            measured_for: None,
            receivers: None,
            truth: None,
            sides: [SideFigures::default(), SideFigures::default()],
        }
    }

    /// Whether truth was asked for.
    pub(crate) fn is_asked(&self) -> bool {
        self.measured_for.is_some()
    }

    /// Whether all of truth is traced, and both sides have their masks, as far as they have shadows.
    #[cfg(not(target_arch = "wasm32"))]
    pub(crate) fn is_complete(&self) -> bool {
        let is_traced = self
            .truth
            .as_ref()
            .is_some_and(|truth| truth.progress >= 1.0);
        let is_known = |side: &SideFigures| side.mask.is_some() || side.refusal.is_some();
        is_traced && self.sides.iter().all(is_known)
    }

    /// Whether masks are on their way.
    pub(crate) fn is_waiting(&self) -> bool {
        self.sides.iter().any(|side| side.pending.is_some())
    }

    /// Forgets all.
    pub(crate) fn forget(&mut self) {
        self.worker.give_up();
        self.truth = None;
        self.receivers = None;
        self.sides = [SideFigures::default(), SideFigures::default()];
        self.measured_for = None;
    }

    /// Forgets a side's mask, since its technique changed.
    pub(crate) fn forget_mask(&mut self, side: usize, renderer: &mut Renderer) {
        self.sides[side] = SideFigures::default();
        renderer.overlays[side].clear();
    }

    /// Asks for truth if nothing moves, and takes what is there. `ready` says of each side whether its set was made ready for the present
    /// camera, lights and settings: only such a set is asked for masks. Returns whether there is something new.
    pub(crate) fn update(
        &mut self,
        render: &RenderState,
        renderer: &mut Renderer,
        question: &Question<'_>,
        rests: bool,
        ready: [bool; 2],
    ) -> Result<bool> {
        let wanted = MeasuredFor {
            camera: question.camera,
            light: question.light,
            scene: question.geometry.fingerprint(),
        };
        if self.measured_for.as_ref() != Some(&wanted) {
            if self.measured_for.is_some() {
                self.forget();
                renderer
                    .overlays
                    .iter_mut()
                    .for_each(|overlay| overlay.clear());
            }
            if rests {
                self.ask(question);
                self.measured_for = Some(wanted);
            }
            return Ok(false);
        }
        let mut is_new = false;
        match self.worker.news() {
            Some(News::Truth(truth)) if truth.number == self.asked => {
                if self.receivers.is_none() {
                    let textures =
                        ReceiverTextures::new(&render.device, &render.queue, &truth.receivers);
                    self.receivers = Some(textures);
                }
                self.truth = Some(truth);
                is_new = true;
            }
            Some(News::Failed(error)) => anyhow::bail!(error),
            _ => {}
        }
        let has_masks = self.fetch_masks(render, renderer, question.place, ready)?;
        let has_places = self.take_places()?;
        Ok(is_new || has_masks || has_places)
    }

    /// Takes pictures of where lookups go that were made since. Returns whether one was.
    fn take_places(&mut self) -> Result<bool> {
        let mut has_news = false;
        for side in &mut self.sides {
            if let Some(places) = &mut side.places
                && let Some(rgba) = places.job.take()
            {
                places.is_under_way = false;
                places.rgba = rgba?;
                has_news = true;
            }
        }
        Ok(has_news)
    }

    fn ask(&mut self, question: &Question<'_>) {
        self.asked += 1;
        self.worker.ask(TruthRequest {
            camera: question.camera,
            geometry: question.geometry.clone(),
            light: question.light,
            samples: TRUTH_RAYS,
            number: self.asked,
        });
    }

    /// Has both sides make a light's mask, and takes masks that are there. Returns whether one is.
    fn fetch_masks(
        &mut self,
        render: &RenderState,
        renderer: &mut Renderer,
        light: usize,
        ready: [bool; 2],
    ) -> Result<bool> {
        let Some(receivers) = &self.receivers else {
            return Ok(false);
        };
        let mut has_news = false;
        let sides = renderer.sides.iter_mut().zip(&mut self.sides);
        for ((side, figures), is_ready) in sides.zip(ready) {
            if let Some(pending) = &figures.pending {
                if let Some(read) = pending.take()? {
                    figures.mask = Some(read.mask);
                    figures.lookup_ms = read.milliseconds;
                    figures.pending = None;
                    has_news = true;
                }
            } else if is_ready
                && figures.mask.is_none()
                && figures.refusal.is_none()
                && let Some(&light) = side.ids.get(light)
            {
                // A light without shadows is lit everywhere, which says nothing of the technique.
                if let Some(refusal) = side.refusal(light) {
                    figures.refusal = Some(refusal);
                    has_news = true;
                    continue;
                }
                let (device, queue) = (&render.device, &render.queue);
                let pending = PendingMask::request(device, queue, &mut side.set, light, receivers)?;
                figures.pending = Some(pending);
            }
        }
        render.device.poll(wgpu::PollType::Poll)?;
        Ok(has_news)
    }

    /// Compares masks with truth, and lays a picture of it over the sides.
    pub(crate) fn compare(
        &mut self,
        render: &RenderState,
        renderer: &mut Renderer,
        question: &Question<'_>,
        techniques: [&SideSettings; 2],
        shown: &ShownFigures,
    ) {
        let Some(truth) = &self.truth else {
            return;
        };
        let size = truth.receivers.size;
        let seen = SeenFrom {
            camera: &question.camera,
            light: &question.light,
            geometry: question.geometry,
            casters: renderer.sides[0].set.casters_box(),
            receivers: &truth.receivers,
        };
        // Times are of one side at a time: each takes all cores.
        let mut times_another = self.sides.iter().any(SideFigures::times_lookups);
        let sides = self.sides.iter_mut().zip(&mut renderer.overlays);
        for ((side, overlay), settings) in sides.zip(techniques) {
            let mask = side.mask.as_deref();
            side.error = mask.map(|mask| figures::mask_error(truth, mask));
            let preset = settings.preset_for(&question.light);
            if side.cost.is_none() && mask.is_some() {
                match Cost::of(&preset, &seen) {
                    Ok(cost) => side.cost = Some(cost),
                    Err(error) => side.refusal = Some(format!("{error:#}")),
                }
            }
            overlay.opacity = shown.opacity;
            let rgba = match shown.picture.places() {
                // What refuses the light looks nothing up.
                Some(_) if side.refusal.is_some() => None,
                // Tracing takes all cores: times would be of that.
                Some(Places::Heat) if !truth.is_checked => None,
                Some(kind) => {
                    let is_there = side.places.as_ref().is_some_and(|there| there.kind == kind);
                    let waits = kind == Places::Heat && times_another;
                    if !is_there && !waits {
                        times_another |= kind == Places::Heat;
                        let technique = preset.technique();
                        let work = places::job(kind, technique, &seen, truth.receivers.clone());
                        let wake = self.wake.clone();
                        side.places = Some(PlacesPicture {
                            kind,
                            job: Beside::start(work, move || wake()),
                            rgba: None,
                            is_under_way: true,
                        });
                    }
                    let there = side.places.as_ref().filter(|there| there.kind == kind);
                    there.and_then(|there| there.rgba.clone())
                }
                None => figures::picture(shown.picture, truth, mask),
            };
            match rgba {
                Some(rgba) => overlay.show(&render.device, &render.queue, size, &rgba),
                None => overlay.clear(),
            }
        }
    }
}
