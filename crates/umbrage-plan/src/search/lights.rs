//! All lights of a scene under one budget.
//!
//! Each light has a front of settings, from no shadow at all to the most accurate. No other setting
//! of that light beats them in both time and error. One setting of each light is chosen (the
//! multiple-choice knapsack problem). The search adds one light after the other, and keeps the
//! pairs (sum of times, sum of squared errors) that no other pair beats (Nemhauser and Ullmann
//! 1969, "Discrete dynamic programming and capital allocation"). The result is exact, since any
//! part of an optimal choice is optimal itself.
//!
//! Maps that are kept from frame to frame take no time, whatever their size. So among choices of
//! equal time, settings with fewer bytes replace others while the budget permits
//! ([`with_fewer_bytes`]).

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
/// Sums of times that differ by less than this share are equal.
const EQUAL_TIMES: f64 = 0.02;

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

/// Replaces settings by others with fewer bytes, within these limits of both sums.
///
/// Each step chooses the replacement that saves the most bytes for its increase of the squared
/// error.
fn with_fewer_bytes(
    mut picks: Picks,
    lists: &[Vec<Item>],
    max_milliseconds: f64,
    max_squares: f64,
) -> Picks {
    loop {
        let mut best: Option<(f64, Picks)> = None;
        for (light, list) in lists.iter().enumerate() {
            let old = list[picks.places[light]];
            for (place, new) in list.iter().enumerate() {
                if new.bytes >= old.bytes {
                    continue;
                }
                let mut other = picks.clone();
                other.places[light] = place;
                other.milliseconds = other.sum_of(lists, |item| item.milliseconds);
                other.squares = other.sum_of(lists, |item| item.square);
                if other.milliseconds > max_milliseconds || other.squares > max_squares {
                    continue;
                }
                let increase = (new.square - old.square).max(f64::MIN_POSITIVE);
                let gain = (old.bytes - new.bytes) as f64 / increase;
                if best.as_ref().is_none_or(|(most, _)| gain > *most) {
                    best = Some((gain, other));
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
    /// Returns verified settings, from no shadow at all to the most accurate. Each has the least
    /// time for a smaller error than the one before. `limits` are those of [`plan_lights`].
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
        for rung in RUNGS.map(|rung| (rung * error_of_none).min(1.0)) {
            if out
                .last()
                .is_some_and(|last| last.estimate.is_surely_within(rung))
            {
                continue;
            }
            match self.search_for(&of_error(rung))? {
                Found::Chosen(mut found) => out.push(found.swap_remove(0).1),
                Found::Missed(_) => break,
            }
        }
        Ok(out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::FrameMotion;
    use glam::UVec2;

    /// Compares with all possible choices.
    #[test]
    fn picks_are_the_best_of_all() {
        let random = |i: u32| f64::from(umbrage_core::light_sample::hash(i)) / f64::from(u32::MAX);
        for seed in 0..50 {
            let lists: Vec<Vec<Item>> = (0..3)
                .map(|light| {
                    (0..5)
                        .map(|i| {
                            let at = 100 * seed + 10 * light + 2 * i;
                            Item {
                                milliseconds: random(at),
                                square: random(at + 1),
                                bytes: 0,
                            }
                        })
                        .collect()
                })
                .collect();
            let budget = 0.5 + random(seed + 77);
            let mut least = f64::INFINITY;
            for [i, j, k] in (0..125).map(|n| [n / 25, n / 5 % 5, n % 5]) {
                let [a, b, c] = [lists[0][i], lists[1][j], lists[2][k]];
                if a.milliseconds + b.milliseconds + c.milliseconds <= budget {
                    least = least.min(a.square + b.square + c.square);
                }
            }
            let picks = best_picks(&lists);
            let found = picks.iter().rev().find(|p| p.milliseconds <= budget);
            let found = found.map_or(f64::INFINITY, |p| p.squares);
            assert_eq!(found, least, "seed {seed}");
        }
    }

    /// Kept maps of all sizes take equal times: the error bound decides about their sizes.
    #[test]
    fn equal_times_go_to_fewer_bytes() {
        let item = |milliseconds, square, bytes| Item {
            milliseconds,
            square,
            bytes,
        };
        let list = vec![
            item(0.0, 1.0, 0),
            item(1.0, 0.02, 6),
            item(1.0, 0.01, 24),
            item(1.0, 0.001, 384),
            item(1.5, 0.001, 12),
        ];
        let lists = vec![list; 9];
        let bytes = |picks: &Picks| picks.sum_of(&lists, |item| item.bytes as f64);
        let within = |max_squares: f64| {
            let picks = best_picks(&lists);
            let found = picks.iter().find(|p| p.squares <= max_squares);
            let found = found.expect("within the bound").clone();
            let saved = with_fewer_bytes(
                found.clone(),
                &lists,
                1.001 * found.milliseconds,
                max_squares,
            );
            assert!(saved.milliseconds <= 1.001 * found.milliseconds);
            assert!(saved.squares <= max_squares, "{saved:?}");
            [bytes(&found), bytes(&saved)]
        };
        assert_eq!(within(0.091), [9.0 * 384.0, 9.0 * 24.0]);
        assert_eq!(within(0.181), [9.0 * 384.0, 9.0 * 6.0]);
        // Nothing smaller is within a bound that only the largest maps meet.
        assert_eq!(within(0.0091), [9.0 * 384.0, 9.0 * 384.0]);
        // One smaller map saves as many bytes as the bound permits.
        assert_eq!(within(0.0185), [9.0 * 384.0, 8.0 * 384.0 + 24.0]);
    }

    fn lights(budget: LightsBudget) -> LightsPlan {
        let scene = umbrage_scenes::by_argument("cubes").expect("built in");
        // The same light twice, and one that lights nothing.
        let astray = umbrage_core::Light::Spot {
            position: 50.0 * glam::Vec3::Y,
            direction: glam::Vec3::Y,
            inner: 0.1,
            outer: 0.2,
            radius: 0.0,
        };
        let scene = Scene {
            lights: vec![scene.lights[0], scene.lights[0], astray],
            ..scene
        };
        let options = PlanOptions {
            samples: 1024,
            size: Some(UVec2::new(160, 120)),
            motion: FrameMotion::AllMoves,
            ..PlanOptions::default()
        };
        plan_lights(&scene, budget, &Bounds::default(), &options, None, &|_| {})
            .expect("can be planned")
    }

    #[test]
    fn equal_lights_share_a_budget_and_an_unseen_one_takes_none_of_it() {
        let plan = lights(LightsBudget::Error(0.05));
        assert!(plan.miss.is_none() && plan.high <= 0.05, "{plan:?}");
        let names: Vec<&str> = plan
            .lights
            .iter()
            .map(|light| &*light.chosen.as_ref().expect("chosen").technique)
            .collect();
        assert_ne!(names[0], "none");
        assert_eq!(names[2], "none", "its shadow is not visible");
        // The same time buys no greater error.
        let again = lights(LightsBudget::Milliseconds(plan.milliseconds));
        assert!(again.high <= plan.high && again.milliseconds <= plan.milliseconds);
        // Choose a budget halfway between that and the least time.
        let quickest = |light: &LightPlan| {
            let times = light.front.iter().map(|setting| setting.milliseconds);
            times.fold(f64::INFINITY, f64::min)
        };
        let least: f64 = plan.lights.iter().map(quickest).sum();
        assert!(least < plan.milliseconds);
        let halfway = 0.5 * (least + plan.milliseconds);
        let little = lights(LightsBudget::Milliseconds(halfway));
        assert!(little.miss.is_none() && little.error > plan.error);
    }

    #[test]
    fn what_cannot_be_is_reported() {
        let time = lights(LightsBudget::Milliseconds(0.0));
        assert!(
            time.miss
                .is_some_and(|miss| miss.contains("even without any shadow"))
        );
        assert!(LightsBudget::Milliseconds(-1.0).validate().is_err());
        assert!(LightsBudget::Error(2.0).validate().is_err());
    }
}
