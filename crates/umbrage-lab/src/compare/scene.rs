//! Compares all technique settings on one scene.

use super::{
    Backends, CompareEvent, CompareOptions, CompareRow, Measured, OnEvent, RowOutcome, SceneInput,
    SceneResult, TruthSummary,
    agreement::agree,
    control,
    kept_truth::TruthSubject,
    planned::{Planned, PlayedSetting},
    seen::SeenByBackend,
    slug::NamedSetting,
    timing::{DeviceClock, measure},
};
use crate::{LabError, color};
use glam::UVec2;
use std::sync::Arc;
use umbrage_core::{
    Backend, BackendError, Camera, Cast, CastMode, Geometry, Invalid, Light, LightSpace, Receivers,
    Recipe, RecipeError, ShadowTechnique as _, Shadows, View,
    metrics::{Agreement, Causes, Errors, Pixel, ReferenceMask, TruthImage},
};
use umbrage_plan::{
    catalogue::CataloguedKernel,
    cost::Work,
    footprint::{self, Heat, MapUse},
    truth::{self, Truth, TruthOptions},
};
use umbrage_techniques::TechniquePreset;

/// Side of the pictures of where maps are looked up, pixels: enough detail, in files that are small beside the masks'.
const HEAT_SIDE: u32 = 256;

/// The images of one scene.
#[derive(Clone, Debug)]
pub struct SceneImages {
    /// Ray-traced truth.
    pub truth: Truth,
    /// Masks, one for each row in the result's order; none where a row isn't measured.
    pub masks: Vec<Option<Vec<f32>>>,
    /// Shaded pictures as PNG, one for each row; none where a row isn't measured, or without [`CompareOptions::color`].
    pub colors: Vec<Option<Vec<u8>>>,
    /// Where maps are looked up, one for each row; none where a row isn't measured or has no map. None at all in comparisons of
    /// more than three scenes, whose reports don't show them.
    pub lookups: Vec<Option<Arc<Heat>>>,
}

/// The camera, the light and the triangles of a scene, without receivers.
#[derive(Clone, Copy)]
pub(super) struct SceneView<'a> {
    pub(super) camera: &'a Camera,
    pub(super) light: &'a Light,
    pub(super) geometry: &'a Geometry,
}

impl<'a> SceneView<'a> {
    /// Returns the same as core's type.
    pub(super) fn core(&self) -> View<'a> {
        View::new(self.camera, self.light, self.geometry)
    }
}

/// Traces truth about a scene and plays all settings on all backends. With `heat`, keeps where each row's maps are looked up.
pub(super) fn run(
    input: &SceneInput,
    settings: &[NamedSetting],
    options: &CompareOptions,
    heat: bool,
    backends: &mut Backends,
    on_event: &OnEvent<'_>,
) -> Result<(SceneResult, SceneImages), LabError> {
    let scene = &input.scene;
    let (camera, light) = camera_and_light(scene)?;
    let camera = options.camera(camera);
    let geometry = Geometry::bake(scene)?;
    let view = SceneView {
        camera: &camera,
        light,
        geometry: &geometry,
    };
    let truth = truth(&view, &options.truth, backends, on_event)?;
    let stage = if options.color {
        Some(color_stage(input, &camera)?)
    } else {
        None
    };
    let mut run = SceneRun {
        name: &scene.name,
        view,
        truth: &truth,
        reference: ReferenceMask::new(truth.size, &truth.visibility, &truth.pixels)?,
        image: truth.image()?,
        options,
        heat,
        rows: Vec::new(),
        masks: Vec::new(),
        controls: Vec::new(),
        stage,
        colors: Vec::new(),
        lookups: Vec::new(),
        looked_up: Vec::new(),
        played: Vec::new(),
        scene_times: Vec::new(),
        seen: backends.playing.iter().map(|_| None).collect(),
    };
    backends.device_clock = DeviceClock::new(None);
    for setting in settings {
        run.setting(setting, backends, on_event)?;
    }
    let truth_summary = summary(&truth, options);
    let rmse_of_lit = rmse_of_constant(1.0, &run.reference, &truth);
    let rmse_of_dark = rmse_of_constant(0.0, &run.reference, &truth);
    let mut result = SceneResult {
        name: scene.name.clone(),
        summary: input.summary.clone(),
        section: input.section,
        motion: options.motion,
        light: light.kind().to_owned(),
        is_ideal: light.is_ideal(),
        size: camera.size.to_array(),
        triangles: geometry.triangles().len() as u64,
        fingerprint: format!("{:016x}", truth.fingerprint),
        nothing_compared: nothing_compared(&truth_summary, truth.pixels.len()),
        truth: truth_summary,
        rmse_of_none: [rmse_of_lit, rmse_of_dark],
        rows: run.rows,
        controls: run.controls,
    };
    if let Some(yardstick_ms) = backends.device_clock.least_yardstick() {
        result.set_full_clock(yardstick_ms);
    }
    let masks = run.masks;
    let colors = run.colors;
    let lookups = run.lookups;
    let images = SceneImages {
        truth,
        masks,
        colors,
        lookups,
    };
    Ok((result, images))
}

/// Returns truth: what is kept of it, or else traced now and kept.
fn truth(
    view: &SceneView<'_>,
    options: &TruthOptions,
    backends: &mut Backends,
    on_event: &OnEvent<'_>,
) -> Result<Truth, LabError> {
    let subject = TruthSubject {
        camera: view.camera,
        light: view.light,
        geometry: view.geometry,
        options,
    };
    let receivers = &mut backends.receivers;
    if let Some(kept) = &backends.kept_truth {
        let seen = receivers.receivers(view.camera, view.geometry)?;
        if let Some(truth) = kept.read(&subject, seen) {
            return Ok(truth);
        }
    }
    let truth = truth::trace(
        view.camera,
        view.light,
        view.geometry,
        options,
        &mut |camera, geometry| receivers.receivers(camera, geometry),
        &|done, total| on_event(CompareEvent::Truth { done, total }),
    )?;
    if let Some(kept) = &backends.kept_truth
        && let Err(why) = kept.write(&subject, &truth)
    {
        // It is known now, and the next run can trace it again.
        let notice = format!("Truth is not kept for the next run: {why}.");
        backends.notices.push(notice);
        backends.kept_truth = None;
    }
    Ok(truth)
}

/// Returns the RMSE of a mask that has one visibility everywhere; 0 if it can't be measured.
fn rmse_of_constant(visibility: f32, reference: &ReferenceMask<'_>, truth: &Truth) -> f64 {
    let mask = vec![visibility; truth.pixels.len()];
    reference.errors(&mask).map_or(0.0, |errors| errors.rmse)
}

/// Returns the scene for color pictures, seen by this camera, with a marker at the light.
fn color_stage(input: &SceneInput, camera: &Camera) -> Result<color::Stage, Invalid> {
    let scene = umbrage_core::Scene {
        cameras: vec![*camera],
        ..input.scene.clone()
    };
    color::Stage::new(&scene, input.fit)
}

/// Returns a scene's first camera and first light, which are the ones compared.
pub(super) fn camera_and_light(scene: &umbrage_core::Scene) -> Result<(&Camera, &Light), Invalid> {
    let camera = scene
        .cameras
        .first()
        .ok_or_else(|| missing(scene, "camera"))?;
    let light = scene
        .lights
        .first()
        .ok_or_else(|| missing(scene, "light"))?;
    Ok((camera, light))
}

fn missing(scene: &umbrage_core::Scene, what: &str) -> Invalid {
    Invalid::new(
        format!("scene `{}`", scene.name),
        format!("has no {what}"),
        "add one",
    )
}

fn summary(truth: &Truth, options: &CompareOptions) -> TruthSummary {
    let [mean_error, largest_error] = truth.standard_error();
    TruthSummary {
        samples: options.truth.samples,
        mean_error,
        largest_error,
        counted: count(&truth.pixels, Pixel::Counted),
        ambiguous: count(&truth.pixels, Pixel::Ambiguous),
        unlit: count(&truth.pixels, Pixel::Unlit),
        unsampled: count(&truth.pixels, Pixel::Unsampled),
        seconds: options.runs.map(|_| truth.elapsed.as_secs_f64()),
    }
}

fn count(pixels: &[Pixel], kind: Pixel) -> u64 {
    pixels.iter().filter(|pixel| **pixel == kind).count() as u64
}

/// Returns why no pixel counts; none if one does.
fn nothing_compared(truth: &TruthSummary, pixels: usize) -> Option<String> {
    if truth.counted > 0 {
        return None;
    }
    let ambiguous = truth.ambiguous;
    let unlit = truth.unlit;
    let empty = pixels as u64 - ambiguous - unlit - truth.unsampled;
    let help = if ambiguous > 0 {
        "; bring the light nearer, or make the scene larger beside its distances"
    } else {
        ""
    };
    Some(format!(
        "no pixel was compared: of {pixels}, {empty} show nothing that receives, {unlit} face away from the light or lie \
         outside its cone, and at {ambiguous} truth hangs on rounding{help}"
    ))
}

/// A scene while its settings are played.
pub(super) struct SceneRun<'a> {
    name: &'a str,
    pub(super) view: SceneView<'a>,
    pub(super) truth: &'a Truth,
    reference: ReferenceMask<'a>,
    image: TruthImage<'a>,
    pub(super) options: &'a CompareOptions,
    /// Whether to keep where maps are looked up.
    heat: bool,
    /// The rows so far. `masks`, `colors` and `lookups` have one entry for each.
    pub(super) rows: Vec<CompareRow>,
    pub(super) masks: Vec<Option<Vec<f32>>>,
    controls: Vec<super::Control>,
    /// The scene for color pictures; none without them.
    stage: Option<color::Stage>,
    pub(super) colors: Vec<Option<Vec<u8>>>,
    pub(super) lookups: Vec<Option<Arc<Heat>>>,
    /// Footprints measured so far.
    looked_up: Vec<LookedUp>,
    /// Settings played so far. Empty unless only the settings that stand for each technique are played.
    pub(super) played: Vec<PlayedSetting>,
    /// How long techniques take once for the scene, by name, milliseconds.
    pub(super) scene_times: Vec<(&'static str, f64)>,
    /// What each backend sees; none before its first rendering.
    seen: Vec<Option<SeenByBackend>>,
}

/// A footprint that has been measured. Most settings differ only in their bias: their maps are used alike, so that one
/// measurement serves all.
struct LookedUp {
    maps: Vec<CastMap>,
    /// How far the kernel reaches, texels.
    reach: f32,
    map_use: MapUse,
    heat: Option<Arc<Heat>>,
}

/// The map that a cast draws.
#[derive(PartialEq)]
struct CastMap {
    space: LightSpace,
    /// Size of the image, texels.
    size: UVec2,
    layers: u32,
}

/// What the CPU renders for a setting, and how far its mask is from truth.
struct OfCpu {
    shadows: Shadows,
    accuracy: Accuracy,
}

/// How far a mask is from truth, and why; none where no pixel counts.
#[derive(Clone, Copy)]
struct Accuracy {
    errors: Option<Errors>,
    causes: Option<Causes>,
}

impl SceneRun<'_> {
    /// Plays one setting on all backends. The recipe is made once, so that all play the same.
    fn setting(
        &mut self,
        setting: &NamedSetting,
        backends: &mut Backends,
        on_event: &OnEvent<'_>,
    ) -> Result<(), LabError> {
        let technique = &setting.technique;
        let planned = match self.planned(technique)? {
            Ok(planned) => Ok(planned),
            Err(RecipeError::Unsupported(reason)) => Err(reason),
            Err(e) => return Err(e.into()),
        };
        if let Ok(planned) = &planned
            && let Some(first_row) = self.played_alike(&planned.recipe)
        {
            self.repeat(setting, first_row, backends);
            return Ok(());
        }
        let first_row = self.rows.len();
        let mut of_cpu = None;
        for i in 0..backends.playing.len() {
            let backend = backends.playing[i].kind();
            on_event(CompareEvent::Row {
                technique: &setting.name,
                settings: &setting.settings,
                backend,
                index: self.rows.len(),
            });
            let outcome = match &planned {
                Ok(planned) => self.play(setting, planned, i, &mut of_cpu, backends)?,
                Err(reason) => self.unsupported(reason),
            };
            self.rows.push(CompareRow {
                technique: setting.name.clone(),
                settings: setting.settings.clone(),
                slug: setting.slug.clone(),
                backend: backend.to_owned(),
                same_as: None,
                outcome,
            });
        }
        self.colors.resize(self.rows.len(), None);
        self.lookups.resize(self.rows.len(), None);
        if let Ok(planned) = planned {
            self.add_map_use(technique, &planned.recipe, backends.playing.len());
            self.shade(technique, backends)?;
            if self.options.headline {
                self.played.push(PlayedSetting {
                    recipe: planned.recipe,
                    first_row,
                });
            }
        }
        Ok(())
    }

    /// Adds how the maps of the last setting are used to those of its `count` rows that were measured. It is measured once,
    /// since all backends play the same.
    fn add_map_use(&mut self, technique: &TechniquePreset, recipe: &Recipe, count: usize) {
        let first = self.rows.len() - count;
        let is_any_measured = self.rows[first..]
            .iter()
            .any(|row| row.measured().is_some());
        if !is_any_measured {
            return;
        }
        let Some((map_use, heat)) = self.map_use(technique, recipe) else {
            return;
        };
        for i in first..self.rows.len() {
            if let RowOutcome::Measured(measured) = &mut self.rows[i].outcome {
                measured.maps = Some(map_use);
                self.lookups[i] = heat.clone();
            }
        }
    }

    /// Returns the use of a recipe's maps and, with `heat`, where they are looked up; none without maps.
    fn map_use(
        &mut self,
        technique: &TechniquePreset,
        recipe: &Recipe,
    ) -> Option<(MapUse, Option<Arc<Heat>>)> {
        let catalogue = &self.options.catalogue;
        let reach = catalogue.kernel_reach(technique)?;
        let kernel = catalogue.kernel(recipe);
        let receivers = &self.truth.receivers;
        let maps: Vec<CastMap> = recipe
            .casts
            .iter()
            .filter(|cast| cast.mode == CastMode::Depth)
            .map(|cast| cast_map(cast, recipe))
            .collect();
        // Where the kernel's reach differs from receiver to receiver, `reach` doesn't tell kernels apart.
        let varies = reach_varies(kernel, receivers);
        if !varies {
            let known = self
                .looked_up
                .iter()
                .find(|known| known.maps == maps && known.reach == reach);
            if let Some(known) = known {
                return Some((known.map_use, known.heat.clone()));
            }
        }
        let view = self.view.core().with_receivers(receivers);
        let footprint = footprint::measure(&view, recipe, receivers, reach, kernel);
        let heat = if self.heat {
            footprint.heat(HEAT_SIDE).map(Arc::new)
        } else {
            None
        };
        if !varies {
            self.looked_up.push(LookedUp {
                maps,
                reach,
                map_use: footprint.total,
                heat: heat.clone(),
            });
        }
        Some((footprint.total, heat))
    }

    /// Renders color pictures of the last setting's measured rows and compares them with the first backend's.
    fn shade(
        &mut self,
        technique: &TechniquePreset,
        backends: &mut Backends,
    ) -> Result<(), LabError> {
        let Some(stage) = &self.stage else {
            return Ok(());
        };
        let recipe = match stage.recipe(technique, &self.truth.receivers) {
            Ok(recipe) => recipe,
            // The light's marker may be what the technique can't serve; the mask was made without it.
            Err(RecipeError::Unsupported(_)) => return Ok(()),
            Err(e) => return Err(e.into()),
        };
        let first_row = self.rows.len() - backends.playing.len();
        let mut first: Option<Shadows> = None;
        for (backend, row) in backends.playing.iter_mut().zip(first_row..) {
            let RowOutcome::Measured(measured) = &mut self.rows[row].outcome else {
                continue;
            };
            let shadows = backend.render(&stage.view()?, &recipe)?;
            measured.color_differing = first
                .as_ref()
                .and_then(|first| color::differing(first, &shadows));
            self.colors[row] = color::png(self.truth.size, &shadows).transpose()?;
            first.get_or_insert(shadows);
        }
        Ok(())
    }

    /// Returns the outcome of a row without figures; it has no mask either.
    fn unsupported(&mut self, reason: &str) -> RowOutcome {
        self.masks.push(None);
        RowOutcome::Unsupported {
            reason: reason.to_owned(),
        }
    }

    /// Plays and measures one recipe on one backend.
    fn play(
        &mut self,
        setting: &NamedSetting,
        planned: &Planned,
        backend: usize,
        of_cpu: &mut Option<OfCpu>,
        backends: &mut Backends,
    ) -> Result<RowOutcome, LabError> {
        let recipe = &planned.recipe;
        let view = self.view.core();
        let player = &mut *backends.playing[backend];
        let kind = player.kind();
        let snapping = player.snapping();
        let view_of_truth = view.with_receivers(&self.truth.receivers);
        let work = Work::of(&view_of_truth, recipe, &self.options.catalogue);
        let prices = self.options.prices.of(kind);
        let cost_ms = prices.milliseconds(&work);
        let played_cost_ms = prices.milliseconds(&work.played());
        let runs = self.options.runs.as_ref();
        // Every row of a scene has the same receivers: a backend finds them in its first one.
        let seen = self.seen[backend].as_ref().map(|seen| &seen.receivers);
        let seeing = View {
            receivers: seen,
            ..view
        };
        let clock = &mut backends.device_clock;
        let (mut shadows, times) =
            match measure(player, &seeing, recipe, runs, played_cost_ms, clock) {
                Ok(measured) => measured,
                // The report says what is too large for a backend; other backends may still execute it.
                Err(BackendError::Invalid(e)) => return Ok(self.unsupported(&e.to_string())),
                Err(e) => return Err(e.into()),
            };
        if times.is_some() && shadows.timings.receive.is_none() {
            return Ok(self.unsupported("this adapter cannot time its passes"));
        }
        match seen {
            Some(seen) => shadows.receivers = Some(seen.clone()),
            None => self.find_out_what_is_seen(backend, player, &shadows)?,
        }
        self.add_control(player, &setting.technique, recipe, &shadows)?;
        let pixels = self.seen[backend]
            .as_ref()
            .and_then(|seen| seen.pixels.as_deref());
        let accuracy = self.accuracy(of_cpu.as_ref(), &shadows, pixels)?;
        let agreement = match &of_cpu {
            None => None,
            Some(cpu) => {
                let agreed = agree(&view, recipe, &cpu.shadows, &shadows, snapping)?;
                let rmse_of_cpu = self.rmse(&cpu.shadows.mask, pixels)?;
                Some(Agreement {
                    excess: accuracy.errors.map_or(0.0, |e| e.rmse - rmse_of_cpu),
                    ..agreed
                })
            }
        };
        self.masks.push(Some(shadows.mask.clone()));
        let bytes = shadows.bytes;
        if kind == "cpu" {
            *of_cpu = Some(OfCpu { shadows, accuracy });
        }
        let measured = Measured {
            errors: accuracy.errors,
            causes: accuracy.causes,
            times,
            preparation: planned.preparation,
            kept_as_camera_moves: planned.kept_as_camera_moves,
            work,
            cost_ms,
            played_cost_ms: Some(played_cost_ms),
            lookup_cost_ms: prices.lookup_milliseconds(&work),
            bytes,
            agreement,
            color_differing: None,
            maps: None,
        };
        Ok(RowOutcome::Measured(Box::new(measured)))
    }

    /// Finds out which pixels count on a backend, by its first rendering.
    fn find_out_what_is_seen(
        &mut self,
        backend: usize,
        player: &dyn Backend,
        shadows: &Shadows,
    ) -> Result<(), LabError> {
        self.seen[backend] = Some(SeenByBackend::new(
            self.name,
            &self.view,
            self.truth,
            &self.options.truth,
            player,
            shadows,
        )?);
        Ok(())
    }

    /// Plays the negative control of a technique on a backend with the first of its settings that is measured there.
    fn add_control(
        &mut self,
        player: &mut dyn Backend,
        technique: &TechniquePreset,
        recipe: &Recipe,
        shadows: &Shadows,
    ) -> Result<(), LabError> {
        let kind = player.kind();
        let has_control = self
            .controls
            .iter()
            .any(|c| c.backend == kind && c.technique == technique.name());
        if !has_control {
            let control = control::run(
                player,
                technique,
                &self.view,
                self.truth,
                recipe,
                shadows,
                &self.options.catalogue,
            )?;
            self.controls.extend(control);
        }
        Ok(())
    }

    /// Returns a mask's RMSE over the pixels that count: by `pixels`, or by truth without them.
    fn rmse(&self, mask: &[f32], pixels: Option<&[Pixel]>) -> Result<f64, Invalid> {
        Ok(match pixels {
            None => self.reference.errors(mask)?.rmse,
            Some(pixels) => self.reference.with_pixels(pixels)?.errors(mask)?.rmse,
        })
    }

    /// Compares a mask with truth over the pixels that count: by `pixels`, or by truth without them.
    fn accuracy(
        &self,
        of_cpu: Option<&OfCpu>,
        shadows: &Shadows,
        pixels: Option<&[Pixel]>,
    ) -> Result<Accuracy, Invalid> {
        let mask = &shadows.mask;
        // A mask that equals the CPU's has its errors, if the same pixels count.
        if let Some(cpu) = of_cpu
            && pixels.is_none()
            && cpu.shadows.mask == *mask
        {
            return Ok(cpu.accuracy);
        }
        let errors;
        let causes;
        if let Some(pixels) = pixels {
            let image = self.image.with_pixels(pixels)?;
            errors = self.reference.with_pixels(pixels)?.errors(mask)?;
            causes = Causes::measure(mask, &image)?;
        } else {
            errors = self.reference.errors(mask)?;
            causes = Causes::measure(mask, &self.image)?;
        }
        let any_counts = errors.counted > 0;
        Ok(Accuracy {
            errors: any_counts.then_some(errors),
            causes: any_counts.then_some(causes),
        })
    }
}

fn cast_map(cast: &Cast, recipe: &Recipe) -> CastMap {
    let image = &recipe.images[cast.image];
    CastMap {
        space: cast.space,
        size: image.size,
        layers: image.layers,
    }
}

/// Whether the kernel's reach differs from receiver to receiver
/// ([`CataloguedKernel::reach`]); the first receiver is asked.
fn reach_varies(kernel: &dyn CataloguedKernel, receivers: &Receivers) -> bool {
    let Some(first) = receivers.receives.iter().position(|receives| *receives) else {
        return false;
    };
    kernel
        .reach(receivers.position(first), receivers.normal(first))
        .is_some()
}
