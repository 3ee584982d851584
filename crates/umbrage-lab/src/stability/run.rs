//! Plays all rows with all techniques.

use super::{
    case_truth::CaseTruth,
    cell::{CaseResult, Cell, CellOutcome, Stability},
    criterion::Criterion,
    guard,
    measure::Measure,
    motion::Moving,
    play::Still,
    row::{StabilityCase, StabilityRow},
    rows::{cases, rows},
    settings::settings,
    threads::{self, SharedBackends},
};
use crate::{compare::Backends, error::LabError};
use glam::UVec2;
use std::{
    sync::{
        Arc,
        mpsc::{SyncSender, sync_channel},
    },
    thread,
};
use umbrage_core::{Backend, Invalid, ShadowTechnique as _};
use umbrage_plan::catalogue::Catalogue;
use umbrage_plan::truth::TruthOptions;
use umbrage_scenes::motion::Motion;
use umbrage_techniques::TechniquePreset;

/// What to play, and how carefully.
#[derive(Clone, Debug, PartialEq)]
pub struct StabilityOptions {
    /// Rows by number, or cases by name; all when empty.
    pub rows: Vec<String>,
    /// The techniques that there are.
    pub catalogue: Catalogue,
    /// Techniques by name; all when empty.
    pub techniques: Vec<String>,
    /// Image size, pixels.
    pub size: UVec2,
    /// Side of the maps, texels.
    pub map_size: u32,
    /// Frames of moving cases, 2 or more.
    pub frames: u32,
    /// How truth is traced.
    pub truth: TruthOptions,
}

impl Default for StabilityOptions {
    fn default() -> Self {
        let truth = TruthOptions {
            samples: 256,
            probe_samples: 32,
            ..TruthOptions::default()
        };
        Self {
            rows: Vec::new(),
            catalogue: Catalogue::built_in(),
            techniques: Vec::new(),
            size: UVec2::new(240, 180),
            map_size: 1024,
            frames: 10,
            truth,
        }
    }
}

impl StabilityOptions {
    /// Returns options for a quick preview: small images, small maps, few frames and samples.
    pub fn quick() -> Self {
        let truth = TruthOptions {
            samples: 64,
            probe_samples: 16,
            penumbra_factor: 2,
            ..TruthOptions::default()
        };
        Self {
            size: UVec2::new(120, 90),
            map_size: 512,
            frames: 5,
            truth,
            ..Self::default()
        }
    }

    fn wants(&self, row: &StabilityRow, case: &StabilityCase) -> bool {
        self.rows.is_empty() || self.rows.iter().any(|word| is_named(row, case, word))
    }

    fn wants_technique(&self, name: &str) -> bool {
        self.techniques.is_empty() || self.techniques.iter().any(|t| t == name)
    }

    /// Checks that all rows and techniques exist.
    ///
    /// # Errors
    /// Errors on the first name that doesn't exist; the error says what there is.
    pub fn validate(&self) -> Result<(), Invalid> {
        for word in &self.rows {
            if !cases().any(|(row, case)| is_named(row, case, word)) {
                return Err(Invalid::new(
                    "row",
                    format!("there is none called `{word}`"),
                    format!(
                        "use a row's number, 1 to {}, or the name of a case, such as thin-plate",
                        rows().len()
                    ),
                ));
            }
        }
        self.catalogue.select(&self.techniques)?;
        Ok(())
    }
}

/// Whether `word` selects a case: its row's number, its own name, or its scene's.
fn is_named(row: &StabilityRow, case: &StabilityCase, word: &str) -> bool {
    row.is_called(word) || case.name == word || case.scene == word
}

/// Progress of a run.
#[derive(Clone, Copy, Debug)]
pub enum StabilityEvent<'a> {
    /// A case begins.
    Case {
        /// Its name.
        name: &'a str,
        /// Its index among all that are played, from 0.
        index: usize,
        /// The number of all that are played.
        of: usize,
    },
    /// A case has ended.
    Done {
        /// Its result.
        result: &'a CaseResult,
    },
}

/// Plays the chosen rows on all backends; of moving rows, all but the first backend play only the
/// first and the last frame. A technique that fails a row is a result. What must never happen (NaN,
/// a panic, a validation error, backends that disagree) is listed in [`Stability::faults`].
///
/// # Errors
/// Errors if a name is unknown, there is no backend, or a scene can't be used.
pub fn run(
    options: &StabilityOptions,
    backends: &mut Backends,
    on_event: &mut dyn FnMut(StabilityEvent<'_>),
) -> Result<Stability, LabError> {
    options.validate()?;
    some_backend(backends)?;
    let wanted: Vec<(&StabilityRow, &StabilityCase)> = cases()
        .filter(|(row, case)| options.wants(row, case))
        .collect();
    let mut out = Stability {
        backends: backends
            .playing
            .iter()
            .map(|b| b.kind().to_owned())
            .collect(),
        map_size: options.map_size,
        size: options.size.to_array(),
        frames: options.frames,
        ..Stability::default()
    };
    let wanted = &wanted;
    thread::scope(|scope| {
        // The receiver ends with this closure, after an error, too: then the other thread stops.
        let (sender, receiver) = sync_channel(CASES_AHEAD);
        // Truth takes all cores for a while, and what a device renders takes one: so the next cases
        // are prepared meanwhile.
        scope.spawn(move || prepare_all(wanted, options, &sender));
        for (index, (row, case)) in wanted.iter().copied().enumerate() {
            on_event(StabilityEvent::Case {
                name: case.name,
                index,
                of: wanted.len(),
            });
            // The other thread has ended if it panicked, which the scope then passes on.
            let Ok(prepared) = receiver.recv() else {
                break;
            };
            let result = play_case(row, case, &prepared?, options, backends)?;
            on_event(StabilityEvent::Done { result: &result });
            out.faults.extend(faults(&result));
            out.cases.push(result);
        }
        Ok(out)
    })
}

/// Cases that are prepared ahead of the one that runs.
const CASES_AHEAD: usize = 1;

/// A case with all that is traced for it.
struct Prepared {
    case_truth: Arc<CaseTruth>,
    /// Where limits come from, if that is another scene.
    elsewhere: Option<CaseTruth>,
    /// The same scene at scale 1, for [`Measure::ScaleDrift`].
    reference: Option<CaseTruth>,
    /// Its frames, if anything moves.
    moving: Option<Moving>,
}

/// Prepares cases in their order, until one can't be or nobody waits for more.
fn prepare_all(
    cases: &[(&StabilityRow, &StabilityCase)],
    options: &StabilityOptions,
    sender: &SyncSender<Result<Prepared, LabError>>,
) {
    let mut last: Option<(&StabilityCase, Arc<CaseTruth>)> = None;
    for &(_, case) in cases {
        // Neighbours in the list often share a scene; its truth is traced once.
        let known = last
            .take()
            .filter(|(before, _)| has_same_truth(before, case))
            .map(|(_, case_truth)| case_truth);
        let prepared = prepare(case, known, options);
        if let Ok(prepared) = &prepared {
            last = Some((case, prepared.case_truth.clone()));
        }
        let is_last = prepared.is_err();
        if sender.send(prepared).is_err() || is_last {
            return;
        }
    }
}

fn prepare(
    case: &StabilityCase,
    known: Option<Arc<CaseTruth>>,
    options: &StabilityOptions,
) -> Result<Prepared, LabError> {
    let case_truth = match known {
        Some(case_truth) => case_truth,
        None => Arc::new(self::case_truth(case, case.scene, options)?),
    };
    let elsewhere = match case.limits_from {
        Some(scene) => Some(self::case_truth(case, scene, options)?),
        None => None,
    };
    let is_moving = case.motion != Motion::Still;
    let moving = if is_moving {
        let frames = options.frames;
        Some(Moving::new(
            &case_truth,
            case.motion,
            frames,
            &options.truth,
        )?)
    } else {
        None
    };
    Ok(Prepared {
        reference: reference(case, options)?,
        case_truth,
        elsewhere,
        moving,
    })
}

/// Whether two cases begin with the same view of the same scene: only a widening motion changes the
/// first camera ([`Motion::first_camera`]).
fn has_same_truth(a: &StabilityCase, b: &StabilityCase) -> bool {
    let a_widens = a.motion == Motion::Widening;
    let b_widens = b.motion == Motion::Widening;
    a.scene == b.scene && a.lights == b.lights && a_widens == b_widens
}

/// Traces truth about a scene, seen and lit as a case says.
///
/// # Errors
/// Errors if the scene doesn't exist or can't be used.
pub fn case_truth(
    case: &StabilityCase,
    scene: &str,
    options: &StabilityOptions,
) -> Result<CaseTruth, LabError> {
    let entry = umbrage_scenes::find(scene).ok_or_else(|| {
        Invalid::new(
            "scene",
            format!("there is none called `{scene}`"),
            "use a built-in one",
        )
    })?;
    let scene = (entry.build)();
    let camera = case
        .motion
        .first_camera(&scene.cameras[0].resized(options.size));
    let lights = scene.lights.iter().take(case.lights).copied().collect();
    CaseTruth::new(scene, camera, lights, options.map_size, &options.truth)
}

fn play_case(
    row: &StabilityRow,
    case: &StabilityCase,
    prepared: &Prepared,
    options: &StabilityOptions,
    backends: &mut Backends,
) -> Result<CaseResult, LabError> {
    let case_truth = &*prepared.case_truth;
    let techniques = techniques_of(case, options);
    let still_limits = |measure: Measure| match &prepared.elsewhere {
        Some(elsewhere) => measure.limits_from(case_truth, elsewhere),
        None => measure.limits(case_truth),
    };
    let criteria;
    let backends = SharedBackends::new(backends);
    let cells: Vec<Result<Cell, LabError>>;
    if let Some(moving) = &prepared.moving {
        criteria = Criterion::of_case(case.measure, case_truth, |measure| {
            moving.limits(measure, still_limits(measure))
        });
        cells = threads::map(&techniques, |technique| {
            moving.cell(technique, &criteria, &backends)
        });
    } else {
        criteria = Criterion::of_case(case.measure, case_truth, still_limits);
        let still = Still {
            case_truth,
            reference: prepared.reference.as_ref(),
            criteria: &criteria,
            catalogue: &options.catalogue,
        };
        cells = threads::map(&techniques, |technique| still.cell(technique, &backends));
    }
    Ok(CaseResult {
        row: row.number,
        title: row.title.to_owned(),
        weakness: row.weakness.to_owned(),
        not_yet: row.not_yet.map(str::to_owned),
        case: case.name.to_owned(),
        scene: case.scene.to_owned(),
        motion: case.motion.label().to_owned(),
        fit: case.fit.label(),
        is_sanity: !case_truth.truth.has_shadow(),
        criteria: criteria.iter().map(|c| c.result(case_truth)).collect(),
        cells: cells.into_iter().collect::<Result<_, _>>()?,
    })
}

/// Errors if there is no backend.
pub(super) fn some_backend(backends: &Backends) -> Result<(), Invalid> {
    if backends.playing.is_empty() {
        return Err(Invalid::new(
            "stability",
            "has no backend",
            "open at least one",
        ));
    }
    Ok(())
}

/// Returns the settings that a case runs with: those of the catalogue, then the case's own.
fn techniques_of(case: &StabilityCase, options: &StabilityOptions) -> Vec<TechniquePreset> {
    let mut out = settings(
        &options.catalogue,
        &options.techniques,
        options.map_size,
        case.fit,
    );
    if let Some(extra) = case.extra {
        let wanted = extra(options.map_size)
            .into_iter()
            .filter(|technique| options.wants_technique(technique.name()));
        out.extend(wanted);
    }
    out
}

/// Returns truth about the scene that a case is compared with, if its measure needs one: the same
/// scene at scale 1.
fn reference(
    case: &StabilityCase,
    options: &StabilityOptions,
) -> Result<Option<CaseTruth>, LabError> {
    match case.measure {
        Measure::ScaleDrift(scene) => case_truth(case, scene, options).map(Some),
        _ => Ok(None),
    }
}

/// Returns a message for each cell that shows what must never happen.
fn faults(result: &CaseResult) -> Vec<String> {
    let mut out = Vec::new();
    for cell in &result.cells {
        let name = format!("{}: {} ({})", result.case, cell.technique, cell.settings);
        if let CellOutcome::Fault { what } = &cell.outcome {
            out.push(format!("{name}: {what}"));
            continue;
        }
        match cell.disagreeing {
            None | Some(0) => {}
            Some(n) => out.push(format!("{name}: backends differ on {n} decided pixels")),
        }
    }
    out
}

/// Compares backends that have played with fresh ones of the same kind. Returns a message for each
/// whose picture differs.
///
/// # Errors
/// Errors if the picture can't be played.
pub fn check_state(
    used: &mut [Box<dyn Backend + Send>],
    fresh: &mut [Box<dyn Backend + Send>],
) -> Result<Vec<String>, LabError> {
    let mut out = Vec::new();
    for used in used {
        let Some(fresh) = fresh.iter_mut().find(|f| f.kind() == used.kind()) else {
            continue;
        };
        if !guard::is_as_new(&mut **used, &mut **fresh)? {
            out.push(format!(
                "{}: a control picture after the run differs from a fresh backend's",
                used.name()
            ));
        }
    }
    Ok(out)
}
