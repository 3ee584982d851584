//! Rows of one technique setting on a scene. Makes the recipe, executes and times it on every
//! backend, and measures its error. Each backend's figures are a row.

use super::{
    agreement::agree,
    backends::Backends,
    control,
    event::{CompareEvent, OnEvent},
    map_uses::MapUses,
    options::CompareOptions,
    result::{CompareRow, Control, Measured, Preparation, RowOutcome},
    seen::{SceneView, SeenByBackend},
    settings::NamedSetting,
    timing::{measure, time_of_scene, time_recipe},
};
use crate::{color, error::LabError};
use std::sync::Arc;
use umbrage_core::{
    Backend, BackendError, Invalid, Recipe, RecipeError, ShadowTechnique, Shadows, Snapping, View,
    metrics::{Agreement, Causes, Errors, Pixel, ReferenceMask, TruthImage},
};
use umbrage_plan::{
    cost::Work,
    footprint::Heat,
    motion::{draw_alike, follows_camera, table_alike},
    truth::Truth,
};
use umbrage_techniques::TechniquePreset;

/// Images of a row. All are `None` if it isn't measured.
#[derive(Clone, Debug, Default)]
pub struct RowImages {
    /// The mask.
    pub mask: Option<Vec<f32>>,
    /// The shaded image as PNG. `None` without [`CompareOptions::color`].
    pub color: Option<Vec<u8>>,
    /// Locations of lookups in the maps. `None` without a map, and in comparisons of more than
    /// three scenes, whose reports don't show it.
    pub lookups: Option<Arc<Heat>>,
}

/// State of a scene while its settings are compared.
pub(super) struct SceneRun<'a> {
    pub(super) name: &'a str,
    pub(super) view: SceneView<'a>,
    pub(super) options: &'a CompareOptions,
    pub(super) judge: Judge<'a>,
    /// The scene for colour images. `None` without them.
    pub(super) stage: Option<color::ColorScene>,
    /// The rows so far.
    pub(super) rows: Vec<(CompareRow, RowImages)>,
    pub(super) controls: Vec<Control>,
    pub(super) map_uses: MapUses,
    /// Settings executed so far. Only recorded if the representative settings of each technique are
    /// compared.
    pub(super) executed: Vec<ExecutedSetting>,
    /// Preparation time of each technique per scene, by name, milliseconds.
    pub(super) scene_times: Vec<(&'static str, f64)>,
    /// Receivers that each backend sees. `None` before its first rendering.
    pub(super) seen: Vec<Option<SeenByBackend>>,
}

/// An executed setting.
pub(super) struct ExecutedSetting {
    recipe: Recipe,
    /// First of its rows, of which there is one for each backend.
    first_row: usize,
}

/// A recipe with its preparation.
struct MadeRecipe {
    recipe: Recipe,
    /// `None` if times aren't measured.
    preparation: Option<Preparation>,
    kept_as_camera_moves: bool,
}

/// The CPU's result for a setting, and its error.
struct OfCpu {
    shadows: Shadows,
    accuracy: Accuracy,
}

impl SceneRun<'_> {
    /// Executes one setting on all backends. They share one recipe.
    pub(super) fn add_setting(
        &mut self,
        setting: &NamedSetting,
        backends: &mut Backends,
        on_event: &OnEvent<'_>,
    ) -> Result<(), LabError> {
        let technique = &setting.technique;
        let made = match self.make_recipe(technique) {
            Ok(made) => Ok(made),
            Err(RecipeError::Unsupported(reason)) => Err(reason),
            Err(e) => return Err(e.into()),
        };
        if let Ok(made) = &made
            && let Some(first_row) = self.first_row_alike(&made.recipe)
        {
            self.repeat(setting, first_row, backends.backends.len());
            return Ok(());
        }
        // The CPU has no hierarchies.
        let is_of_device = made.as_ref().is_ok_and(|m| m.recipe.hierarchy.is_some());
        if is_of_device && backends.backends.iter().all(|b| b.kind() == "cpu") {
            return Ok(());
        }
        let first_row = self.rows.len();
        let mut of_cpu = None;
        for i in 0..backends.backends.len() {
            let backend = backends.backends[i].kind();
            on_event(CompareEvent::Row {
                technique: &setting.name,
                settings: &setting.settings,
                backend,
                index: self.rows.len(),
            });
            let (outcome, images) = match &made {
                Ok(made) => self.execute(setting, made, i, &mut of_cpu, backends)?,
                Err(reason) => unsupported_row(reason),
            };
            let row = CompareRow {
                technique: setting.name.clone(),
                settings: setting.settings.clone(),
                slug: setting.slug.clone(),
                backend: backend.to_owned(),
                same_as: None,
                outcome,
            };
            self.rows.push((row, images));
        }
        if let Ok(made) = made {
            self.add_map_use(technique, &made.recipe, first_row);
            self.shade(technique, first_row, backends)?;
            if self.options.headline {
                self.executed.push(ExecutedSetting {
                    recipe: made.recipe,
                    first_row,
                });
            }
        }
        Ok(())
    }

    /// Makes a setting's recipe. Times it if the options include times.
    fn make_recipe(&mut self, technique: &dyn ShadowTechnique) -> Result<MadeRecipe, RecipeError> {
        if let Some(reason) = self.too_slow(technique) {
            return Err(RecipeError::unsupported_because(reason));
        }
        let mut view = self.view.core();
        if self.options.knows_receivers {
            view = view.with_receivers(&self.judge.truth.receivers);
        }
        if self.options.runs.is_none() {
            let recipe = technique.recipe(&view)?;
            return Ok(MadeRecipe {
                kept_as_camera_moves: !follows_camera(technique, &recipe, &view),
                recipe,
                preparation: None,
            });
        }
        let (recipe, times) = time_recipe(technique, &view)?;
        let kept_as_camera_moves = !follows_camera(technique, &recipe, &view);
        let name = technique.name();
        let known = self.scene_times.iter().find(|known| known.0 == name);
        let scene_ms = match known {
            Some(&(_, ms)) => ms,
            None => {
                let ms = time_of_scene(technique, &view, times.median);
                self.scene_times.push((name, ms));
                ms
            }
        };
        Ok(MadeRecipe {
            recipe,
            preparation: Some(Preparation {
                scene_ms,
                recipe: times,
            }),
            kept_as_camera_moves,
        })
    }

    /// Returns why a technique is skipped when representative settings are compared. `None` if it
    /// isn't.
    fn too_slow(&self, technique: &dyn ShadowTechnique) -> Option<String> {
        let entry = self.options.catalogue.find(technique.name())?;
        let most = entry.max_compared_triangles?;
        let triangles = self.view.geometry.triangles().len();
        if !self.options.headline || triangles <= most {
            return None;
        }
        Some(format!(
            "skipped on scenes of over {most} triangles, where it takes minutes; name the scene, or request all settings"
        ))
    }

    /// Executes and measures one recipe on one backend.
    fn execute(
        &mut self,
        setting: &NamedSetting,
        made: &MadeRecipe,
        backend_index: usize,
        of_cpu: &mut Option<OfCpu>,
        backends: &mut Backends,
    ) -> Result<(RowOutcome, RowImages), LabError> {
        // Count the work and predict its cost.
        let recipe = &made.recipe;
        let view = self.view.core();
        let backend = &mut *backends.backends[backend_index];
        let kind = backend.kind();
        let snapping = backend.snapping();
        let view_of_truth = view.with_receivers(&self.judge.truth.receivers);
        let work = Work::of_recipe(&view_of_truth, recipe, &self.options.catalogue);
        let prices = self.options.prices.model_for_backend(kind);
        let executed_cost_ms = prices.milliseconds(&work.without_lists());
        // The CPU has no hierarchies. For these recipes it only renders, by lists, the mask with
        // which the others are compared.
        let is_only_compared = kind == "cpu" && recipe.hierarchy.is_some();
        let runs = self.options.runs.as_ref().filter(|_| !is_only_compared);
        // Reuse the receivers of the backend's first row: they are the same for the whole scene.
        let seen = self.seen[backend_index].as_ref();
        let seen = seen.map(|seen| &seen.receivers);
        let seeing = View {
            receivers: seen,
            ..view
        };
        // Render and time the recipe.
        let clock = &mut backends.device_clock;
        let (mut shadows, times) =
            match measure(backend, &seeing, recipe, runs, executed_cost_ms, clock) {
                Ok(measured) => measured,
                // The report states what is too large for a backend. Others may still execute it.
                Err(BackendError::Invalid(e)) => return Ok(unsupported_row(&e.to_string())),
                Err(e) => return Err(e.into()),
            };
        if times.is_some() && shadows.timings.receive.is_none() {
            return Ok(unsupported_row("this adapter cannot time its passes"));
        }
        match seen {
            Some(seen) => shadows.receivers = Some(seen.clone()),
            None => self.find_out_what_is_seen(backend_index, backend, &shadows)?,
        }
        // Compare the mask with casters removed, with truth, and with the CPU's.
        self.add_control(backend, &setting.technique, recipe, &shadows)?;
        let pixels = self.seen[backend_index].as_ref();
        let pixels = pixels.and_then(|seen| seen.pixels.as_deref());
        let accuracy = self.accuracy(of_cpu.as_ref(), &shadows, pixels)?;
        let agreement = match &of_cpu {
            None => None,
            Some(cpu) => Some(self.agreement(cpu, &shadows, accuracy, recipe, snapping, pixels)?),
        };
        let measured = Measured {
            errors: accuracy.errors,
            causes: accuracy.causes,
            times,
            preparation: made.preparation,
            kept_as_camera_moves: made.kept_as_camera_moves,
            work,
            cost_ms: prices.milliseconds(&work),
            executed_cost_ms: Some(executed_cost_ms),
            lookup_cost_ms: prices.lookup_milliseconds(&work),
            bytes: shadows.bytes,
            agreement,
            color_differing: None,
            maps: None,
        };
        let images = RowImages {
            mask: Some(shadows.mask.clone()),
            ..RowImages::default()
        };
        if kind == "cpu" {
            *of_cpu = Some(OfCpu { shadows, accuracy });
        }
        if is_only_compared {
            return Ok(unsupported_row(ONLY_ON_DEVICES));
        }
        Ok((RowOutcome::Measured(Box::new(measured)), images))
    }

    /// Determines which pixels count on a backend from its first rendering.
    fn find_out_what_is_seen(
        &mut self,
        backend_index: usize,
        backend: &dyn Backend,
        shadows: &Shadows,
    ) -> Result<(), LabError> {
        self.seen[backend_index] = Some(SeenByBackend::new(
            self.name,
            &self.view,
            self.judge.truth,
            &self.options.truth,
            backend,
            shadows,
        )?);
        Ok(())
    }

    /// Runs the negative control of a technique on a backend, with the technique's first setting
    /// that is measured there.
    fn add_control(
        &mut self,
        backend: &mut dyn Backend,
        technique: &TechniquePreset,
        recipe: &Recipe,
        shadows: &Shadows,
    ) -> Result<(), LabError> {
        let kind = backend.kind();
        let has_control = self
            .controls
            .iter()
            .any(|c| c.backend == kind && c.technique == technique.name());
        if !has_control {
            let control = control::run(
                backend,
                technique,
                &self.view,
                self.judge.truth,
                recipe,
                shadows,
                &self.options.catalogue,
            )?;
            self.controls.extend(control);
        }
        Ok(())
    }

    /// Compares a mask with truth. A mask that equals the CPU's has the same errors, if the same
    /// pixels count.
    fn accuracy(
        &self,
        of_cpu: Option<&OfCpu>,
        shadows: &Shadows,
        pixels: Option<&[Pixel]>,
    ) -> Result<Accuracy, LabError> {
        if let Some(cpu) = of_cpu
            && pixels.is_none()
            && cpu.shadows.mask == shadows.mask
        {
            return Ok(cpu.accuracy);
        }
        Ok(self.judge.accuracy(&shadows.mask, pixels)?)
    }

    /// Compares a mask with the CPU's.
    fn agreement(
        &self,
        cpu: &OfCpu,
        shadows: &Shadows,
        accuracy: Accuracy,
        recipe: &Recipe,
        snapping: Snapping,
        pixels: Option<&[Pixel]>,
    ) -> Result<Agreement, LabError> {
        let agreed = agree(&self.view.core(), recipe, &cpu.shadows, shadows, snapping)?;
        let rmse_of_cpu = self.judge.errors(&cpu.shadows.mask, pixels)?.rmse;
        Ok(Agreement {
            excess: accuracy.errors.map_or(0.0, |e| e.rmse - rmse_of_cpu),
            ..agreed
        })
    }

    /// Adds the use of maps to the measured rows from `first_row` on. It is measured once, since
    /// all backends execute the same recipe.
    fn add_map_use(&mut self, technique: &TechniquePreset, recipe: &Recipe, first_row: usize) {
        let rows = &mut self.rows[first_row..];
        if rows.iter().all(|(row, _)| row.measured_figures().is_none()) {
            return;
        }
        let receivers = &self.judge.truth.receivers;
        let catalogue = &self.options.catalogue;
        let found = self
            .map_uses
            .measure(&self.view, receivers, catalogue, technique, recipe);
        let Some((map_use, heat)) = found else {
            return;
        };
        for (row, images) in rows {
            if let RowOutcome::Measured(measured) = &mut row.outcome {
                measured.maps = Some(map_use);
                images.lookups.clone_from(&heat);
            }
        }
    }

    /// Renders colour images of the measured rows from `first_row` on, and compares them with those
    /// of the first backend.
    fn shade(
        &mut self,
        technique: &TechniquePreset,
        first_row: usize,
        backends: &mut Backends,
    ) -> Result<(), LabError> {
        let Some(stage) = &self.stage else {
            return Ok(());
        };
        let truth = self.judge.truth;
        let recipe = match stage.recipe(technique, &truth.receivers) {
            Ok(recipe) => recipe,
            // The light's marker may be unsupported; the mask was made without it.
            Err(RecipeError::Unsupported(_)) => return Ok(()),
            Err(e) => return Err(e.into()),
        };
        let mut first: Option<Shadows> = None;
        let rows = &mut self.rows[first_row..];
        for (backend, (row, images)) in backends.backends.iter_mut().zip(rows) {
            let RowOutcome::Measured(measured) = &mut row.outcome else {
                continue;
            };
            let shadows = backend.render(&stage.view()?, &recipe)?;
            measured.color_differing = first
                .as_ref()
                .and_then(|first| color::count_differing(first, &shadows));
            images.color = color::png(truth.size, &shadows).transpose()?;
            first.get_or_insert(shadows);
        }
        Ok(())
    }

    /// Returns the first row of a setting with the same recipe. `None` if there is none.
    fn first_row_alike(&self, recipe: &Recipe) -> Option<usize> {
        let mut executed = self.executed.iter();
        let alike = executed.find(|executed| render_alike(&executed.recipe, recipe))?;
        Some(alike.first_row)
    }

    /// Adds rows that repeat the figures of those from `first_row` on.
    fn repeat(&mut self, setting: &NamedSetting, first_row: usize, backends: usize) {
        for i in first_row..first_row + backends {
            let (like, images) = self.rows[i].clone();
            let row = CompareRow {
                technique: setting.name.clone(),
                settings: setting.settings.clone(),
                slug: setting.slug.clone(),
                same_as: Some(format!("{} ({})", like.technique, like.settings)),
                ..like
            };
            self.rows.push((row, images));
        }
    }
}

/// Truth of a scene, prepared for comparison with many masks.
pub(super) struct Judge<'a> {
    truth: &'a Truth,
    reference: ReferenceMask<'a>,
    image: TruthImage<'a>,
}

/// The error of a mask and its causes. `None` if no pixel counts.
#[derive(Clone, Copy)]
struct Accuracy {
    errors: Option<Errors>,
    causes: Option<Causes>,
}

impl<'a> Judge<'a> {
    pub(super) fn new(truth: &'a Truth) -> Result<Self, Invalid> {
        Ok(Self {
            truth,
            reference: ReferenceMask::new(truth.size, &truth.visibility, &truth.pixels)?,
            image: truth.image()?,
        })
    }

    /// Compares a mask with truth over the pixels that count, by `pixels` or else by truth.
    fn accuracy(&self, mask: &[f32], pixels: Option<&[Pixel]>) -> Result<Accuracy, Invalid> {
        let errors = self.errors(mask, pixels)?;
        let causes = match pixels {
            None => Causes::measure(mask, &self.image)?,
            Some(pixels) => Causes::measure(mask, &self.image.with_pixels(pixels)?)?,
        };
        let any_counts = errors.counted > 0;
        Ok(Accuracy {
            errors: any_counts.then_some(errors),
            causes: any_counts.then_some(causes),
        })
    }

    /// Returns the errors of a mask over the pixels that count, by `pixels` or else by truth.
    fn errors(&self, mask: &[f32], pixels: Option<&[Pixel]>) -> Result<Errors, Invalid> {
        match pixels {
            None => self.reference.errors(mask),
            Some(pixels) => self.reference.with_pixels(pixels)?.errors(mask),
        }
    }

    /// Returns the RMSE of a mask with the same visibility everywhere. 0 if it can't be measured.
    pub(super) fn rmse_of_constant(&self, visibility: f32) -> f64 {
        let mask = vec![visibility; self.truth.pixels.len()];
        self.errors(&mask, None).map_or(0.0, |errors| errors.rmse)
    }
}

/// Reason why the CPU has no row of a recipe with a hierarchy.
const ONLY_ON_DEVICES: &str = "only devices build this hierarchy: the CPU uses lists";

/// Returns the outcome of a row without figures and images.
fn unsupported_row(reason: &str) -> (RowOutcome, RowImages) {
    let outcome = RowOutcome::Unsupported {
        reason: reason.to_owned(),
    };
    (outcome, RowImages::default())
}

/// Reports whether two recipes, and so their masks, are the same.
fn render_alike(a: &Recipe, b: &Recipe) -> bool {
    let of_lookup = |recipe: &Recipe| {
        let receive = &recipe.receive;
        format!(
            "{:?} {:?} {:?}",
            receive.kernel, receive.inputs, receive.tables
        )
    };
    let same_tables = a.tables.len() == b.tables.len()
        && (0..a.tables.len()).all(|table| table_alike(a, b, table));
    draw_alike(a, b) && same_tables && of_lookup(a) == of_lookup(b)
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage_core::{Geometry, Light};
    use umbrage_techniques::{Bias, Hard, MapFilter as _, Pcss, ShadowMap, Traced};

    #[test]
    fn the_same_recipe_is_known_under_another_name() {
        let scene = umbrage_scenes::by_argument("cubes").expect("built in");
        let geometry = Geometry::bake(&scene).expect("valid");
        let recipe = |technique: &dyn ShadowTechnique, light: &Light| {
            let view = View::new(&scene.cameras[0], light, &geometry);
            technique.recipe(&view).expect("served")
        };
        let sun = scene.lights[0];
        let map = ShadowMap::default();
        let hard = Hard {}.on(map);
        let pcss = Pcss::default().on(map);
        assert!(render_alike(&recipe(&hard, &sun), &recipe(&pcss, &sun)));
        // They differ under an area light, with another bias or with another map.
        let lamp = umbrage_scenes::by_argument("teapot-lamp")
            .expect("built in")
            .lights[0];
        assert!(!render_alike(&recipe(&hard, &lamp), &recipe(&pcss, &lamp)));
        for other in [
            ShadowMap {
                bias: Bias::SLOPE,
                ..map
            },
            ShadowMap { size: 512, ..map },
        ] {
            let other = Hard {}.on(other);
            assert!(!render_alike(&recipe(&hard, &sun), &recipe(&other, &sun)));
        }
        let few = Traced { samples: 1 };
        let many = Traced { samples: 4 };
        assert!(render_alike(&recipe(&few, &sun), &recipe(&many, &sun)));
        assert!(!render_alike(&recipe(&few, &lamp), &recipe(&many, &lamp)));
    }
}
