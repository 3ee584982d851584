//! All rows of one scene.

use super::{
    Backends, CompareEvent, CompareOptions, CompareRow, Measured, OnEvent, RowOutcome, SceneInput,
    SceneResult, TruthSummary, agreement::agree, control, seen::SeenByBackend, slug::NamedSetting,
    timing::measure,
};
use crate::{LabError, color};
use glam::UVec2;
use std::sync::Arc;
use umbrage_core::{
    BackendError, Camera, Cast, CastMode, Geometry, Invalid, Light, LightSpace, Recipe,
    RecipeError, ShadowTechnique, Shadows, View, Work,
    metrics::{Agreement, Causes, Errors, Pixel, ReferenceMask, TruthImage},
};
use umbrage_plan::{
    cost::CostModel,
    footprint::{self, Heat, MapUse},
    truth::{self, Truth},
};

/// Side of the pictures of where maps are looked up, pixels: enough to see, and little beside the masks.
const HEAT_SIDE: u32 = 256;

/// The images of one scene.
#[derive(Clone, Debug)]
pub struct SceneImages {
    /// What should have been seen.
    pub truth: Truth,
    /// Masks, one a row in the result's order; none where a row isn't measured.
    pub masks: Vec<Option<Vec<f32>>>,
    /// Shaded pictures, PNG, one a row; none where a row isn't measured or colours weren't asked for.
    pub colors: Vec<Option<Vec<u8>>>,
    /// Where maps are looked up, one a row; none where a row isn't measured or has no map, and none of comparisons of more
    /// than three scenes, whose reports have no room for them.
    pub lookups: Vec<Option<Arc<Heat>>>,
}

/// Camera, light and triangles.
#[derive(Clone, Copy)]
pub(super) struct View3<'a> {
    pub(super) camera: &'a Camera,
    pub(super) light: &'a Light,
    pub(super) geometry: &'a Geometry,
}

impl<'a> View3<'a> {
    pub(super) fn core(&self) -> View<'a> {
        View::new(self.camera, self.light, self.geometry)
    }
}

/// Truth and all rows of a scene; with `heat`, where each row's maps are looked up.
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
    let (camera, geometry) = (options.camera(camera), Geometry::bake(scene)?);
    let view = View3 {
        camera: &camera,
        light,
        geometry: &geometry,
    };
    let progress = |done, total| on_event(CompareEvent::Truth { done, total });
    let find = &mut |c: &Camera, g: &Geometry| backends.receivers.receivers(c, g);
    let truth = truth::trace(&camera, light, &geometry, &options.truth, find, &progress)?;
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
        stage: options
            .color
            .then(|| color_stage(input, &camera))
            .transpose()?,
        colors: Vec::new(),
        lookups: Vec::new(),
        looked_up: Vec::new(),
        seen: backends.playing.iter().map(|_| None).collect(),
    };
    for setting in settings {
        run.setting(setting, backends, on_event)?;
    }
    let truth_summary = summary(&truth, options);
    let result = SceneResult {
        name: scene.name.clone(),
        summary: input.summary.clone(),
        light: light.kind().to_owned(),
        size: camera.size.to_array(),
        triangles: geometry.triangles().len() as u64,
        fingerprint: format!("{:016x}", truth.fingerprint),
        nothing_compared: nothing_compared(&truth_summary, truth.pixels.len()),
        truth: truth_summary,
        rmse_of_none: [1.0, 0.0].map(|v| {
            run.reference
                .errors(&vec![v; truth.pixels.len()])
                .map_or(0.0, |e| e.rmse)
        }),
        rows: run.rows,
        controls: run.controls,
    };
    let (masks, colors, lookups) = (run.masks, run.colors, run.lookups);
    Ok((
        result,
        SceneImages {
            truth,
            masks,
            colors,
            lookups,
        },
    ))
}

/// The scene as this camera sees it, marked for pictures.
fn color_stage(input: &SceneInput, camera: &Camera) -> Result<color::Stage, Invalid> {
    let scene = umbrage_core::Scene {
        cameras: vec![*camera],
        ..input.scene.clone()
    };
    color::Stage::new(&scene, input.fit)
}

pub(super) fn camera_and_light(scene: &umbrage_core::Scene) -> Result<(&Camera, &Light), Invalid> {
    let missing = |what| {
        Invalid::new(
            format!("scene `{}`", scene.name),
            format!("has no {what}"),
            "add one",
        )
    };
    let camera = scene.cameras.first().ok_or_else(|| missing("camera"))?;
    let light = scene.lights.first().ok_or_else(|| missing("light"))?;
    Ok((camera, light))
}

fn summary(truth: &Truth, options: &CompareOptions) -> TruthSummary {
    let [mean_error, largest_error] = truth.standard_error();
    let count = |kind: Pixel| truth.pixels.iter().filter(|p| **p == kind).count() as u64;
    TruthSummary {
        samples: options.truth.samples,
        mean_error,
        largest_error,
        counted: count(Pixel::Counted),
        ambiguous: count(Pixel::Ambiguous),
        unlit: count(Pixel::Unlit),
        seconds: options.runs.map(|_| truth.elapsed.as_secs_f64()),
    }
}

/// Why no pixel counts; none if one does.
fn nothing_compared(truth: &TruthSummary, pixels: usize) -> Option<String> {
    let TruthSummary {
        counted,
        ambiguous,
        unlit,
        ..
    } = *truth;
    let empty = pixels as u64 - counted - ambiguous - unlit;
    let help = if ambiguous > 0 {
        "; bring the light nearer, or make the scene larger beside its distances"
    } else {
        ""
    };
    (counted == 0).then(|| {
        format!(
            "no pixel was compared: of {pixels}, {empty} show nothing that receives, {unlit} face away from the light or lie \
             outside its cone, and at {ambiguous} truth hangs on rounding{help}"
        )
    })
}

/// A scene while its rows are made.
struct SceneRun<'a> {
    name: &'a str,
    view: View3<'a>,
    truth: &'a Truth,
    reference: ReferenceMask<'a>,
    image: TruthImage<'a>,
    options: &'a CompareOptions,
    /// Whether to keep where maps are looked up.
    heat: bool,
    rows: Vec<CompareRow>,
    masks: Vec<Option<Vec<f32>>>,
    controls: Vec<super::Control>,
    stage: Option<color::Stage>,
    colors: Vec<Option<Vec<u8>>>,
    lookups: Vec<Option<Arc<Heat>>>,
    looked_up: Vec<LookedUp>,
    /// One entry a backend.
    seen: Vec<Option<SeenByBackend>>,
}

/// A footprint that is known: most settings differ in their bias alone, and their maps are used alike.
struct LookedUp {
    /// Where each cast lies, its image's size and layers.
    maps: Vec<(LightSpace, UVec2, u32)>,
    reach: f32,
    found: (MapUse, Option<Arc<Heat>>),
}

impl SceneRun<'_> {
    /// One setting on all backends: the recipe is planned once, so that all play the same.
    fn setting(
        &mut self,
        setting: &NamedSetting,
        backends: &mut Backends,
        on_event: &OnEvent<'_>,
    ) -> Result<(), LabError> {
        let technique = &*setting.technique;
        let recipe = match technique.recipe(&self.view.core().with_receivers(&self.truth.receivers))
        {
            Ok(recipe) => Ok(recipe),
            Err(RecipeError::Unsupported(reason)) => Err(reason),
            Err(e) => return Err(e.into()),
        };
        let mut of_cpu = None;
        for i in 0..backends.playing.len() {
            let backend = backends.playing[i].kind();
            let (technique, settings) = (technique.name(), &*technique.settings());
            on_event(CompareEvent::Row {
                technique,
                settings,
                backend,
                index: self.rows.len(),
            });
            let outcome = match &recipe {
                Ok(recipe) => self.play(setting, recipe, i, &mut of_cpu, backends)?,
                Err(reason) => self.unsupported(reason),
            };
            let (technique, settings) = (technique.to_owned(), settings.to_owned());
            self.rows.push(CompareRow {
                technique,
                settings,
                slug: setting.slug.clone(),
                backend: backend.to_owned(),
                outcome,
            });
        }
        self.colors.resize(self.rows.len(), None);
        if let Ok(recipe) = &recipe {
            self.look_at_maps(technique, recipe, backends.playing.len());
        }
        self.lookups.resize(self.rows.len(), None);
        if recipe.is_ok() {
            self.shade(technique, backends)
        } else {
            Ok(())
        }
    }

    /// How the last setting's maps are used, of its `rows` rows that were measured: once, since all backends play the same.
    fn look_at_maps(&mut self, technique: &dyn ShadowTechnique, recipe: &Recipe, rows: usize) {
        let first = self.rows.len() - rows;
        if self.rows[first..]
            .iter()
            .all(|row| row.measured().is_none())
        {
            return;
        }
        let Some((total, heat)) = self.map_use(technique, recipe) else {
            return;
        };
        for row in &mut self.rows[first..] {
            let RowOutcome::Measured(measured) = &mut row.outcome else {
                self.lookups.push(None);
                continue;
            };
            measured.maps = Some(total);
            self.lookups.push(heat.clone());
        }
    }

    /// The use of a recipe's maps, and where they are looked up; none without maps.
    fn map_use(
        &mut self,
        technique: &dyn ShadowTechnique,
        recipe: &Recipe,
    ) -> Option<(MapUse, Option<Arc<Heat>>)> {
        let (reach, receivers) = (technique.kernel_reach()?, &self.truth.receivers);
        let nearest = recipe
            .casts
            .iter()
            .filter(|cast| cast.mode == CastMode::Depth);
        let map = |cast: &Cast| {
            (
                cast.space,
                recipe.images[cast.image].size,
                recipe.images[cast.image].layers,
            )
        };
        let maps: Vec<_> = nearest.map(map).collect();
        // A kernel that says each receiver's reach may differ from others though all else is the same.
        let says = |i| {
            recipe
                .receive
                .kernel
                .reach(receivers.position(i), receivers.normal(i))
                .is_some()
        };
        let varies = receivers
            .receives
            .iter()
            .position(|receives| *receives)
            .is_some_and(says);
        let known = self
            .looked_up
            .iter()
            .find(|known| !varies && known.maps == maps && known.reach == reach);
        if let Some(known) = known {
            return Some(known.found.clone());
        }
        let footprint = footprint::measure(
            &self.view.core().with_receivers(receivers),
            recipe,
            receivers,
            reach,
        );
        let heat = if self.heat {
            footprint.heat(HEAT_SIDE)
        } else {
            None
        };
        let found = (footprint.total, heat.map(Arc::new));
        if !varies {
            self.looked_up.push(LookedUp {
                maps,
                reach,
                found: found.clone(),
            });
        }
        Some(found)
    }

    /// Colour pictures of the last setting's measured rows, compared with the first backend's.
    fn shade(
        &mut self,
        technique: &dyn ShadowTechnique,
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

    fn unsupported(&mut self, reason: &str) -> RowOutcome {
        self.masks.push(None);
        RowOutcome::Unsupported {
            reason: reason.to_owned(),
        }
    }

    /// One recipe on one backend.
    fn play(
        &mut self,
        setting: &NamedSetting,
        recipe: &Recipe,
        backend: usize,
        of_cpu: &mut Option<OfCpu>,
        backends: &mut Backends,
    ) -> Result<RowOutcome, LabError> {
        let view = self.view.core();
        let player = &mut *backends.playing[backend];
        let work = Work::of(&view.with_receivers(&self.truth.receivers), recipe);
        let cost_ms = CostModel::of(player.kind()).milliseconds(&work);
        let runs = self.options.runs.as_ref();
        let (shadows, times) = match measure(player, &view, recipe, runs, cost_ms) {
            Ok(measured) => measured,
            // What a backend can't hold is told in the report; other backends may still play it.
            Err(BackendError::Invalid(e)) => return Ok(self.unsupported(&e.to_string())),
            Err(e) => return Err(e.into()),
        };
        if times.is_some() && shadows.timings.receive.is_none() {
            return Ok(self.unsupported("this adapter cannot time its passes"));
        }
        if !self.seen[backend]
            .as_ref()
            .is_some_and(|seen| seen.holds(&shadows))
        {
            self.seen[backend] = Some(SeenByBackend::new(
                self.name,
                &self.view,
                self.truth,
                &self.options.truth,
                player,
                &shadows,
            )?);
        }
        let pixels = self.seen[backend]
            .as_ref()
            .and_then(|seen| seen.pixels.as_deref());
        let snapping = player.snapping();
        let kind = player.kind();
        let technique = setting.technique.name();
        if self
            .controls
            .iter()
            .all(|c| c.backend != kind || c.technique != technique)
        {
            self.controls.extend(control::run(
                player,
                &*setting.technique,
                &self.view,
                self.truth,
                recipe,
                &shadows,
            )?);
        }
        let (errors, causes) = self.errors(of_cpu.as_ref(), &shadows, pixels)?;
        let agreement = match &of_cpu {
            None => None,
            Some((cpu, ..)) => {
                let agreed = agree(&view, recipe, cpu, &shadows, snapping)?;
                let of_cpu = self.rmse(&cpu.mask, pixels)?;
                Some(Agreement {
                    excess: errors.map_or(0.0, |e| e.rmse - of_cpu),
                    ..agreed
                })
            }
        };
        self.masks.push(Some(shadows.mask.clone()));
        let bytes = shadows.bytes;
        if backends.playing[backend].kind() == "cpu" {
            *of_cpu = Some((shadows, errors, causes));
        }
        let measured = Measured {
            errors,
            causes,
            times,
            work,
            cost_ms,
            bytes,
            agreement,
            color_differing: None,
            maps: None,
        };
        Ok(RowOutcome::Measured(Box::new(measured)))
    }

    /// A mask's RMSE where these pixels count, or those that truth says.
    fn rmse(&self, mask: &[f32], pixels: Option<&[Pixel]>) -> Result<f64, Invalid> {
        Ok(match pixels {
            None => self.reference.errors(mask)?.rmse,
            Some(pixels) => self.reference.with_pixels(pixels)?.errors(mask)?.rmse,
        })
    }

    /// Against truth where these pixels count, or those that truth says, and what it comes from; none if no pixel counts. A mask
    /// that equals the CPU's has its errors.
    fn errors(
        &self,
        of_cpu: Option<&OfCpu>,
        shadows: &Shadows,
        pixels: Option<&[Pixel]>,
    ) -> Result<(Option<Errors>, Option<Causes>), Invalid> {
        let mask = &shadows.mask;
        let (errors, causes) = match (of_cpu, pixels) {
            (Some((cpu, errors, causes)), None) if cpu.mask == *mask => {
                return Ok((*errors, *causes));
            }
            (_, None) => (
                self.reference.errors(mask)?,
                Causes::measure(mask, &self.image)?,
            ),
            (_, Some(pixels)) => {
                let image = self.image.with_pixels(pixels)?;
                (
                    self.reference.with_pixels(pixels)?.errors(mask)?,
                    Causes::measure(mask, &image)?,
                )
            }
        };
        Ok(if errors.counted > 0 {
            (Some(errors), Some(causes))
        } else {
            (None, None)
        })
    }
}

/// What the CPU made of a setting, and how far it is from truth.
type OfCpu = (Shadows, Option<Errors>, Option<Causes>);
