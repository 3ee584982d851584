//! Runs all rows with all techniques.

use super::{
    case_truth::CaseTruth,
    cell::{CaseResult, Cell, CellOutcome, Stability},
    criterion::Criterion,
    guard,
    measure::Measure,
    motion::Moving,
    row::{StabilityCase, StabilityRow},
    rows::{cases, rows},
    settings::settings,
    still::Still,
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

/// Selection and effort of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct StabilityOptions {
    /// Rows by number, or cases by name; all when empty.
    pub rows: Vec<String>,
    /// Available techniques.
    pub catalogue: Catalogue,
    /// Techniques by name; all when empty.
    pub techniques: Vec<String>,
    /// Image size, pixels.
    pub size: UVec2,
    /// Side of the maps, texels.
    pub map_size: u32,
    /// Frames of moving cases, 2 or more.
    pub frames: u32,
    /// Settings of the truth tracer.
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
    /// Errors on the first name that doesn't exist; the error lists the valid names.
    pub fn validate(&self) -> Result<(), Invalid> {
        for word in &self.rows {
            if !cases().any(|(row, case)| is_named(row, case, word)) {
                return Err(Invalid::new(
                    "row",
                    format!("`{word}` is unknown"),
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

/// Reports whether `word` selects a case: by its row's number, its own name, or its scene's.
fn is_named(row: &StabilityRow, case: &StabilityCase, word: &str) -> bool {
    row.is_called(word) || case.name == word || case.scene == word
}

/// Progress of a run.
#[derive(Clone, Copy, Debug)]
pub enum StabilityEvent<'a> {
    /// A case begins.
    Case {
        /// Name of the case.
        name: &'a str,
        /// Index of the case in the run, from 0.
        index: usize,
        /// Number of cases of the run.
        of: usize,
    },
    /// A case has ended.
    Done {
        /// Result of the case.
        result: &'a CaseResult,
    },
}

/// Runs the selected rows on all backends. In moving rows, all but the first backend render only
/// the first and the last frame.
///
/// A technique that fails a row is a result. Events that must never happen (NaN, a panic, a
/// validation error, backends that disagree) are listed in [`Stability::faults`].
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
            .backends
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
        // The receiver is dropped with this closure, also after an error; then the other thread
        // stops.
        let (sender, receiver) = sync_channel(CASES_AHEAD);
        // Prepare the next cases meanwhile: truth uses all cores for a while, rendering on a device
        // only one.
        scope.spawn(move || prepare_all(wanted, options, &sender));
        for (index, (row, case)) in wanted.iter().copied().enumerate() {
            on_event(StabilityEvent::Case {
                name: case.name,
                index,
                of: wanted.len(),
            });
            // If the other thread panicked, the scope propagates the panic.
            let Ok(prepared) = receiver.recv() else {
                break;
            };
            let result = run_case(row, case, &prepared?, options, backends)?;
            on_event(StabilityEvent::Done { result: &result });
            out.faults.extend(faults(&result));
            out.cases.push(result);
        }
        Ok(out)
    })
}

/// Number of cases prepared ahead of the running one.
const CASES_AHEAD: usize = 1;

/// A case with its traced data.
struct Prepared {
    case_truth: Arc<CaseTruth>,
    /// Source of the limits, if it is another scene.
    elsewhere: Option<CaseTruth>,
    /// Truth of the same scene at scale 1, for [`Measure::ScaleDrift`].
    reference: Option<CaseTruth>,
    /// Frames of the case, if anything moves.
    moving: Option<Moving>,
}

/// Prepares cases in order, until one fails or the receiver is dropped.
fn prepare_all(
    cases: &[(&StabilityRow, &StabilityCase)],
    options: &StabilityOptions,
    sender: &SyncSender<Result<Prepared, LabError>>,
) {
    let mut last: Option<(&StabilityCase, Arc<CaseTruth>)> = None;
    for &(_, case) in cases {
        // Trace truth once for neighbours in the list that share a scene.
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

/// Reports whether two cases begin with the same view of the same scene. Only a widening motion
/// changes the first camera ([`Motion::first_camera`]).
fn has_same_truth(a: &StabilityCase, b: &StabilityCase) -> bool {
    let a_widens = a.motion == Motion::Widening;
    let b_widens = b.motion == Motion::Widening;
    a.scene == b.scene && a.lights == b.lights && a_widens == b_widens
}

/// Traces truth of a scene with a case's camera and lights.
///
/// # Errors
/// Errors if the scene doesn't exist or is invalid.
pub fn case_truth(
    case: &StabilityCase,
    scene: &str,
    options: &StabilityOptions,
) -> Result<CaseTruth, LabError> {
    let entry = umbrage_scenes::find(scene).ok_or_else(|| {
        Invalid::new(
            "scene",
            format!("`{scene}` is unknown"),
            "use a built-in one",
        )
    })?;
    let scene = (entry.build)();
    let camera = case
        .motion
        .first_camera(&scene.cameras[0].with_size(options.size));
    let lights = scene.lights.iter().take(case.lights).copied().collect();
    CaseTruth::new(scene, camera, lights, options.map_size, &options.truth)
}

fn run_case(
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
    if backends.backends.is_empty() {
        return Err(Invalid::new(
            "stability",
            "has no backend",
            "pass at least one",
        ));
    }
    Ok(())
}

/// Returns the settings of a case: those of the catalogue, then the case's own.
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

/// Returns truth of the same scene at scale 1, if the case's measure needs it.
fn reference(
    case: &StabilityCase,
    options: &StabilityOptions,
) -> Result<Option<CaseTruth>, LabError> {
    match case.measure {
        Measure::ScaleDrift(scene) => case_truth(case, scene, options).map(Some),
        _ => Ok(None),
    }
}

/// Returns a message for each cell with an event that must never happen.
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

/// Compares used backends with fresh ones of the same kind. Returns a message for each whose image
/// differs.
///
/// # Errors
/// Errors if a backend can't render the image.
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
                "{}: a control image after the run differs from a fresh backend's",
                used.name()
            ));
        }
    }
    Ok(out)
}
