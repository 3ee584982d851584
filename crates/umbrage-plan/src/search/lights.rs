//! All lights of a scene under one budget.
//!
//! Each light has a front of settings, from no shadow at all to the most accurate. No other setting
//! of that light beats them in both time and error. One setting of each light is chosen (the
//! multiple-choice knapsack problem). The search adds one light after the other, and keeps the
//! pairs (sum of times, sum of squared errors) that no other pair beats (Nemhauser and Ullmann
//! 1969, "Discrete dynamic programming and capital allocation"). The result is exact, since any
//! part of an optimal choice is optimal itself.
//!
//! Maps that are kept from frame to frame take no time, whatever their size. So a front also has
//! settings with fewer bytes for the same error ([`Planner::front`]). Among choices of equal time,
//! they replace others while the budget permits ([`with_fewer_bytes`]).

use super::{
    bounds::Bounds,
    options::{PlanOptions, no_such},
    planner::Planner,
    setting::Setting,
    strategy::Found,
};
use crate::{
    error::MeasureError,
    estimate::{error::Estimate, sampled_truth::Coverage},
    motion::FrameMotion,
    progress::OnStep,
};
use serde::{Deserialize, Serialize};
use umbrage_core::{Backend, Geometry, Invalid, Scene};
use umbrage_techniques::{TechniquePreset, Unshadowed};

/// Budget that all lights of a scene share.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LightsBudget {
    /// Greatest sum of the lights' times, milliseconds. The plan minimizes the error.
    Milliseconds(f64),
    /// Greatest root mean square of the lights' errors. The plan minimizes the time.
    Error(f64),
}

impl LightsBudget {
    /// Checks the number.
    ///
    /// # Errors
    /// Errors if a time is negative or not finite, or an error is not in 0..=1.
    pub fn validate(self) -> Result<(), Invalid> {
        match self {
            Self::Milliseconds(ms) => Bounds::milliseconds(ms).validate(),
            Self::Error(error) => Bounds::error(error).validate(),
        }
    }
}

/// Plan for all lights of a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LightsPlan {
    /// The scene's name.
    pub scene: String,
    /// Image width and height, pixels.
    pub size: [u32; 2],
    /// Number of cameras that it was made for.
    pub cameras: usize,
    /// Motion from frame to frame.
    pub motion: FrameMotion,
    /// The budget that it meets.
    pub budget: LightsBudget,
    /// Bounds of each light in addition to the budget.
    pub limits: Bounds,
    /// The lights, in the scene's order.
    pub lights: Vec<LightPlan>,
    /// Sum of the chosen settings' times, milliseconds; measured times if they were timed.
    pub milliseconds: f64,
    /// Root mean square of the chosen settings' errors over the lights, 0..=1.
    pub error: f64,
    /// Root mean square of the chosen settings' upper error limits over the lights, 0..=1.
    pub high: f64,
    /// Reason why nothing is within the budget, with the closest possible figure; `None` if
    /// something is.
    pub miss: Option<String>,
}

/// Plan for one light of a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LightPlan {
    /// The light's number, from 1.
    pub number: usize,
    /// The light's kind.
    pub kind: String,
    /// The setting chosen from `front`; `None` if nothing is within the budget.
    pub chosen: Option<Setting>,
    /// Error of no shadow at all.
    pub error_of_no_shadow: Estimate,
    /// The settings that no other evaluated setting beats in time, error and bytes, by rising time.
    pub front: Vec<Setting>,
    /// Number of pixels for which the errors hold.
    pub coverage: Coverage,
}

/// Error bounds for the search of a light's front, as shares of the error of no shadow. Each is
/// less than the one before by about the root of 2, the gain of a map of twice the side.
const RUNGS: [f64; 11] = [
    0.9, 0.7, 0.5, 0.35, 0.25, 0.18, 0.125, 0.09, 0.0625, 0.045, 0.03,
];
/// Sums of times that differ by less than this share are equal. The sums of two runs of the same
/// plan differ by about as much: by 4 % for nine lights on a software driver.
const EQUAL_TIMES: f64 = 0.05;
/// Greatest price of a setting with fewer bytes, as a factor of that of the cheapest setting.
const FEWER_BYTES_PRICE: f64 = 1.2;
/// Each setting with fewer bytes has at most this share of the bytes of the one before.
const FEWER_BYTES: f64 = 0.5;
/// Settings with at most this many bytes are small enough: no smaller ones are searched.
const SMALL_ENOUGH_BYTES: u64 = 1 << 20;

/// Plans all lights of a scene under one budget.
///
/// `limits` are additional bounds of each light, such as grain and memory; its bounds of error and
/// time are ignored. With a backend, the settings of each front run in turn and are timed.
///
/// # Errors
/// Errors if the scene has no camera or light or is not valid, if the budget or the limits are not
/// valid, or if a backend fails.
pub fn plan_lights(
    scene: &Scene,
    budget: LightsBudget,
    limits: &Bounds,
    options: &PlanOptions,
    mut clock: Option<&mut dyn Backend>,
    on_step: &OnStep<'_>,
) -> Result<LightsPlan, MeasureError> {
    budget.validate()?;
    if scene.lights.is_empty() {
        return Err(no_such(scene, "light").into());
    }
    let cameras = options.cameras_of(scene)?;
    let geometry = Geometry::bake(scene)?;
    let mut lights = Vec::new();
    // Search the front of each light.
    for (i, light) in scene.lights.iter().enumerate() {
        let mut planner = Planner::of_cameras(&cameras, light, &geometry, options, on_step)?;
        let settings = planner.front(limits)?;
        let settings = match &mut clock {
            Some(backend) => planner.measure_times(settings, &mut **backend)?,
            None => settings,
        };
        let trials = &mut planner.trials;
        lights.push(LightPlan {
            number: i + 1,
            kind: light.kind().to_owned(),
            chosen: None,
            error_of_no_shadow: trials.error_of_no_shadow()?,
            front: undominated_settings(&settings),
            coverage: trials.coverage(),
        });
    }
    let size = cameras[0].size.to_array();
    let plan = LightsPlan {
        scene: scene.name.clone(),
        size,
        cameras: cameras.len(),
        motion: options.motion,
        budget,
        limits: *limits,
        lights,
        milliseconds: 0.0,
        error: 0.0,
        high: 0.0,
        miss: None,
    };
    Ok(plan.picked_settings())
}

/// Returns the time of a setting, milliseconds: the measured time if it was timed.
fn time_of(setting: &Setting) -> f64 {
    setting.measured_ms.unwrap_or(setting.milliseconds)
}

/// Returns the settings that no other beats in time, error and bytes, by rising time. Keeps the
/// first of equal settings.
fn undominated_settings(settings: &[Setting]) -> Vec<Setting> {
    let figures = |s: &Setting| [time_of(s), s.estimate.high, s.bytes as f64];
    let beats = |i: usize, j: usize| {
        let (a, b) = (figures(&settings[i]), figures(&settings[j]));
        a.iter().zip(&b).all(|(a, b)| a <= b) && (a != b || i < j)
    };
    let all = 0..settings.len();
    let mut out: Vec<Setting> = all
        .clone()
        .filter(|&j| !all.clone().any(|i| i != j && beats(i, j)))
        .map(|j| settings[j].clone())
        .collect();
    out.sort_by(|a, b| {
        (time_of(a).total_cmp(&time_of(b)))
            .then(b.estimate.high.total_cmp(&a.estimate.high))
            .then(a.bytes.cmp(&b.bytes))
    });
    out
}

/// One setting for each of the first lights.
#[derive(Clone, Debug)]
struct Picks {
    milliseconds: f64,
    /// Sum of the squares of the upper error limits.
    squares: f64,
    /// Indices into the lights' fronts.
    places: Vec<usize>,
}

/// Returns all choices of one item of each list that no other choice beats in both sums, by rising
/// time.
fn best_picks(lists: &[Vec<Item>]) -> Vec<Picks> {
    let mut best = vec![Picks {
        milliseconds: 0.0,
        squares: 0.0,
        places: Vec::new(),
    }];
    for list in lists {
        // Combine each kept choice with each item of the list.
        let mut all: Vec<Picks> = Vec::new();
        for picks in &best {
            for (place, item) in list.iter().enumerate() {
                let mut places = picks.places.clone();
                places.push(place);
                all.push(Picks {
                    milliseconds: picks.milliseconds + item.milliseconds,
                    squares: picks.squares + item.square,
                    places,
                });
            }
        }
        all.sort_by(|a, b| {
            (a.milliseconds.total_cmp(&b.milliseconds)).then(a.squares.total_cmp(&b.squares))
        });
        // Keep only the choices with a smaller error than all cheaper ones.
        let mut least = f64::INFINITY;
        all.retain(|picks| {
            let is_better = picks.squares < least;
            least = least.min(picks.squares);
            is_better
        });
        best = all;
    }
    best
}

/// Figures of one setting of a light.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Item {
    milliseconds: f64,
    /// Square of the upper error limit.
    square: f64,
    bytes: u64,
}

/// Replacement of one light's setting, and the changes of its figures.
#[derive(Clone, Copy, Debug)]
struct Replacement {
    light: usize,
    place: usize,
    square: f64,
    saved_bytes: i64,
}

/// Returns each replacement of one light's setting.
fn replacements(picks: &Picks, lists: &[Vec<Item>]) -> Vec<Replacement> {
    let mut all = Vec::new();
    for (light, list) in lists.iter().enumerate() {
        let old = list[picks.places[light]];
        for (place, new) in list.iter().enumerate() {
            if place == picks.places[light] {
                continue;
            }
            all.push(Replacement {
                light,
                place,
                square: new.square - old.square,
                saved_bytes: old.bytes as i64 - new.bytes as i64,
            });
        }
    }
    all
}

/// Replaces settings by others with fewer bytes, within these limits of both sums.
///
/// Each step replaces one or two settings: a second light may take a more accurate or faster
/// setting, so that the first may take a smaller one. It chooses the step that saves the most bytes
/// for its increase of the squared error.
fn with_fewer_bytes(
    mut picks: Picks,
    lists: &[Vec<Item>],
    max_milliseconds: f64,
    max_squares: f64,
) -> Picks {
    loop {
        let all = replacements(&picks, lists);
        let mut best: Option<([f64; 2], Picks)> = None;
        for (i, first) in all.iter().enumerate() {
            // The replacement alone, then with each later one of another light.
            let later = all[i + 1..].iter().filter(|r| r.light != first.light);
            for second in std::iter::once(None).chain(later.map(Some)) {
                let step = || std::iter::once(first).chain(second);
                let saved_bytes: i64 = step().map(|r| r.saved_bytes).sum();
                if saved_bytes <= 0 {
                    continue;
                }
                // Prefer steps that don't increase the error; of these, the greatest saving.
                let increase: f64 = step().map(|r| r.square).sum();
                let saved = saved_bytes as f64;
                let gain = if increase > 0.0 {
                    saved / increase
                } else {
                    f64::INFINITY
                };
                let rank = [gain, saved];
                if best.as_ref().is_some_and(|(most, _)| rank <= *most) {
                    continue;
                }
                let mut other = picks.clone();
                for replacement in step() {
                    other.places[replacement.light] = replacement.place;
                }
                other.milliseconds = other.sum_of(lists, |item| item.milliseconds);
                other.squares = other.sum_of(lists, |item| item.square);
                if other.milliseconds <= max_milliseconds && other.squares <= max_squares {
                    best = Some((rank, other));
                }
            }
        }
        let Some((_, other)) = best else {
            return picks;
        };
        picks = other;
    }
}

impl Picks {
    /// Returns the sum of a figure over the lights.
    fn sum_of(&self, lists: &[Vec<Item>], figure: impl Fn(Item) -> f64) -> f64 {
        let chosen = self.places.iter().zip(lists);
        chosen.map(|(&place, list)| figure(list[place])).sum()
    }
}

impl LightsPlan {
    /// Returns the plan with the best setting chosen for each light.
    fn picked_settings(mut self) -> Self {
        let lists: Vec<Vec<Item>> = self
            .lights
            .iter()
            .map(|light| {
                let item = |s: &Setting| Item {
                    milliseconds: time_of(s),
                    square: s.estimate.high.powi(2),
                    bytes: s.bytes,
                };
                light.front.iter().map(item).collect()
            })
            .collect();
        let picks = best_picks(&lists);
        let count = self.lights.len() as f64;
        let found = match self.budget {
            // The list has rising time and falling error.
            LightsBudget::Milliseconds(max) => picks.iter().rev().find(|p| p.milliseconds <= max),
            LightsBudget::Error(max) => picks.iter().find(|p| (p.squares / count).sqrt() <= max),
        };
        let Some(found) = found else {
            self.miss = Some(self.why_not(&picks));
            return self;
        };
        let equal_time = found.milliseconds * (1.0 + EQUAL_TIMES);
        let [max_milliseconds, max_squares] = match self.budget {
            LightsBudget::Milliseconds(max) => [max.min(equal_time), found.squares],
            LightsBudget::Error(max) => [equal_time, count * max * max],
        };
        let found = with_fewer_bytes(found.clone(), &lists, max_milliseconds, max_squares);
        let mut squares = 0.0;
        for (light, &place) in self.lights.iter_mut().zip(&found.places) {
            let chosen = light.front[place].clone();
            squares += chosen.estimate.error.powi(2);
            light.chosen = Some(chosen);
        }
        self.milliseconds = found.milliseconds;
        self.error = (squares / count).sqrt();
        self.high = (found.squares / count).sqrt();
        self
    }

    fn why_not(&self, picks: &[Picks]) -> String {
        let count = self.lights.len() as f64;
        match (self.budget, picks.first(), picks.last()) {
            (LightsBudget::Milliseconds(max), Some(least), _) => format!(
                "even without any shadow the lights take {:.3} ms, more than {max}; allow more time",
                least.milliseconds
            ),
            (LightsBudget::Error(max), _, Some(best)) => format!(
                "no settings meet an error of {max} for all lights; closest: up to {:.4} in {:.3} ms; allow a greater error",
                (best.squares / count).sqrt(),
                best.milliseconds
            ),
            _ => {
                "a light has no setting within its own limits; allow more grain, shimmer or memory"
                    .to_owned()
            }
        }
    }
}

impl Planner<'_> {
    /// Returns verified settings, from no shadow at all to the most accurate. For each smaller
    /// error, it has the setting of least time, and settings of about its time with fewer bytes.
    /// `limits` are those of [`plan_lights`].
    pub(super) fn front(&mut self, limits: &Bounds) -> Result<Vec<Setting>, MeasureError> {
        let of_error = |error: f64| Bounds {
            max_error: Some(error),
            max_relative_error: None,
            max_ms: None,
            ..*limits
        };
        let trials = &mut self.trials;
        trials.prepare(&of_error(1.0))?;
        // Start with no shadow.
        let none = TechniquePreset::from(Unshadowed::default());
        let mut out: Vec<Setting> = Vec::new();
        if let Some(none) = trials.try_out(&none)? {
            out.push(trials.verify(&none, None, self.on_step)?);
        }
        let error_of_none = out.first().map_or(1.0, |none| none.estimate.high);
        // Search the cheapest setting for each smaller error.
        let mut rungs: Vec<(Bounds, Setting)> = Vec::new();
        let mut cheapest = out.first().cloned();
        for rung in RUNGS.map(|rung| (rung * error_of_none).min(1.0)) {
            let is_within = |last: &Setting| last.estimate.is_surely_within(rung);
            if cheapest.as_ref().is_some_and(is_within) {
                continue;
            }
            let bounds = of_error(rung);
            let Found::Chosen(mut found) = self.search_for(&bounds)? else {
                break;
            };
            let (_, setting) = found.swap_remove(0);
            cheapest = Some(setting.clone());
            rungs.push((bounds, setting));
        }
        // Search smaller ones, from the most accurate on. One that is small enough serves the
        // greater errors, too.
        for (bounds, setting) in rungs.iter().rev() {
            let smaller = self.smaller_settings(setting, bounds)?;
            let is_served = smaller
                .last()
                .is_some_and(|last| last.bytes <= SMALL_ENOUGH_BYTES);
            out.extend(smaller);
            if is_served {
                break;
            }
        }
        out.extend(rungs.into_iter().map(|(_, setting)| setting));
        // A small setting may be the result for several errors.
        let mut presets: Vec<TechniquePreset> = Vec::new();
        out.retain(|setting| {
            let is_new = !presets.contains(&setting.preset);
            presets.push(setting.preset.clone());
            is_new
        });
        Ok(out)
    }

    /// Returns settings within the same bounds with ever fewer bytes, of about the price of the
    /// cheapest one.
    fn smaller_settings(
        &mut self,
        cheapest: &Setting,
        bounds: &Bounds,
    ) -> Result<Vec<Setting>, MeasureError> {
        let mut out = Vec::new();
        let mut bytes = cheapest.bytes;
        while bytes > SMALL_ENOUGH_BYTES {
            let fewer = Bounds {
                max_ms: Some(FEWER_BYTES_PRICE * cheapest.milliseconds),
                max_bytes: Some((FEWER_BYTES * bytes as f64) as u64),
                ..*bounds
            };
            let Found::Chosen(mut found) = self.search_for(&fewer)? else {
                break;
            };
            let (_, setting) = found.swap_remove(0);
            bytes = setting.bytes;
            out.push(setting);
        }
        Ok(out)
    }
}

#[cfg(test)]
#[path = "lights_tests.rs"]
mod tests;
