//! All rows against all techniques.

use super::{
    CaseResult, Cell, CellOutcome, Stability, VerdictLimits,
    case_truth::CaseTruth,
    guard,
    measure::Measure,
    motion::{Moving, first_camera},
    play::Still,
    row::{Motion, StabilityCase, StabilityRow},
    rows::cases,
    settings::settings,
};
use crate::{LabError, compare::Backends};
use glam::UVec2;
use umbrage_core::{Backend, Fit, Invalid};
use umbrage_plan::truth::TruthOptions;
use umbrage_techniques::{ConfiguredTechniques, Techniques};

/// What to play, and how carefully.
#[derive(Clone, Debug, PartialEq)]
pub struct StabilityOptions {
    /// Rows by number, or cases by name; all when empty.
    pub rows: Vec<String>,
    /// The techniques that there are.
    pub registry: Techniques,
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
            registry: Techniques::built_in(),
            techniques: Vec::new(),
            size: UVec2::new(240, 180),
            map_size: 1024,
            frames: 10,
            truth,
        }
    }
}

impl StabilityOptions {
    /// For a first look: small images, small maps, few frames and samples.
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
        let named = |word: &String| row.is_called(word) || case.name == word || case.scene == word;
        self.rows.is_empty() || self.rows.iter().any(named)
    }

    /// Objects to rows and techniques that don't exist.
    ///
    /// # Errors
    /// The first that doesn't, with what there is.
    pub fn validate(&self) -> Result<(), Invalid> {
        let known = |word: &&String| {
            cases()
                .any(|(row, case)| row.is_called(word) || case.name == *word || case.scene == *word)
        };
        if let Some(unknown) = self.rows.iter().find(|word| !known(word)) {
            let help = "use a row's number, 1 to 30, or the name of a case, such as thin-plate";
            return Err(Invalid::new(
                "row",
                format!("there is none called `{unknown}`"),
                help,
            ));
        }
        self.registry.select(&self.techniques)?;
        Ok(())
    }
}

/// What happens, for progress bars.
#[derive(Clone, Copy, Debug)]
pub enum StabilityEvent<'a> {
    /// A case begins: its place among all that are played.
    Case {
        /// Its name.
        name: &'a str,
        /// Its place, from 0.
        index: usize,
        /// How many there are.
        of: usize,
    },
    /// A case has ended.
    Done {
        /// Its result.
        result: &'a CaseResult,
    },
}

/// Plays all rows wanted on all backends; of moving rows, all but the first backend play the first and the last frame. What
/// fails as it is known to is a result; what must not happen (NaN, a panic, a validation error, backends that disagree) is
/// listed in [`Stability::faults`].
///
/// # Errors
/// For unknown names, without a backend, and when a scene can't be used.
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
    let mut last: Option<(&StabilityCase, CaseTruth)> = None;
    for (index, (row, case)) in wanted.iter().copied().enumerate() {
        on_event(StabilityEvent::Case {
            name: case.name,
            index,
            of: wanted.len(),
        });
        // Neighbours in the list often share a scene; its truth is traced once.
        let case_truth = match last.take() {
            Some((before, case_truth)) if has_same_truth(before, case) => case_truth,
            _ => case_truth(case, case.scene, options)?,
        };
        let result = play_case(row, case, &case_truth, options, backends)?;
        on_event(StabilityEvent::Done { result: &result });
        out.faults.extend(faults(&result));
        out.cases.push(result);
        last = Some((case, case_truth));
    }
    Ok(out)
}

fn has_same_truth(a: &StabilityCase, b: &StabilityCase) -> bool {
    let widens = |c: &StabilityCase| c.motion == Motion::Widening;
    a.scene == b.scene && a.lights == b.lights && widens(a) == widens(b)
}

/// Truth of a case's scene.
///
/// # Errors
/// When the scene doesn't exist or can't be used.
pub fn case_truth(
    case: &StabilityCase,
    scene: &str,
    options: &StabilityOptions,
) -> Result<CaseTruth, LabError> {
    let unknown = || {
        Invalid::new(
            "scene",
            format!("there is none called `{scene}`"),
            "use a built-in one",
        )
    };
    let scene = (umbrage_scenes::find(scene).ok_or_else(unknown)?.build)();
    let camera = first_camera(&scene.cameras[0].resized(options.size), case.motion);
    let lights = scene.lights.iter().take(case.lights).copied().collect();
    CaseTruth::new(scene, camera, lights, options.map_size, &options.truth)
}

fn play_case(
    row: &StabilityRow,
    case: &StabilityCase,
    case_truth: &CaseTruth,
    options: &StabilityOptions,
    backends: &mut Backends,
) -> Result<CaseResult, LabError> {
    let chosen = chosen(case, options);
    let (limits, cells) = if case.motion == Motion::Still {
        let limits = case.measure.limits(case_truth);
        (
            limits,
            still_cells(case, case_truth, limits, &chosen, options, backends)?,
        )
    } else {
        let moving = Moving::new(case_truth, case.motion, options.frames, &options.truth)?;
        let cells = chosen
            .iter()
            .map(|t| moving.cell(&**t, case.measure, backends))
            .collect::<Result<_, _>>()?;
        (moving.limits(case.measure), cells)
    };
    Ok(CaseResult {
        row: row.number,
        title: row.title.to_owned(),
        weakness: row.weakness.to_owned(),
        not_yet: row.not_yet.map(str::to_owned),
        case: case.name.to_owned(),
        scene: case.scene.to_owned(),
        motion: case.motion.label().to_owned(),
        measure: case.measure.name().to_owned(),
        unit: case.measure.unit().to_owned(),
        limits,
        reason: case.measure.reason().to_owned(),
        ideal: case.measure.figure(case_truth, &case_truth.ideal),
        cells,
    })
}

/// Objects to no backend at all.
pub(super) fn some_backend(backends: &Backends) -> Result<(), Invalid> {
    let none = || Invalid::new("stability", "has no backend", "open at least one");
    if backends.playing.is_empty() {
        Err(none())
    } else {
        Ok(())
    }
}

/// The settings of a case.
fn chosen(case: &StabilityCase, options: &StabilityOptions) -> ConfiguredTechniques {
    let mut chosen = settings(
        &options.registry,
        &options.techniques,
        options.map_size,
        Fit::Tight,
    );
    let extra = case.extra.map_or_else(Vec::new, |f| f(options.map_size));
    let wanted =
        |name: &str| options.techniques.is_empty() || options.techniques.iter().any(|t| t == name);
    chosen.extend(extra.into_iter().filter(|t| wanted(t.name())));
    chosen
}

fn still_cells(
    case: &StabilityCase,
    case_truth: &CaseTruth,
    limits: VerdictLimits,
    chosen: &ConfiguredTechniques,
    options: &StabilityOptions,
    backends: &mut Backends,
) -> Result<Vec<Cell>, LabError> {
    let at_one = match case.measure {
        Measure::ScaleDrift(scene) => Some(self::case_truth(case, scene, options)?),
        _ => None,
    };
    let still = Still {
        case,
        case_truth,
        reference: at_one.as_ref(),
        limits,
    };
    chosen
        .iter()
        .map(|technique| still.cell(&**technique, backends))
        .collect()
}

fn faults(result: &CaseResult) -> Vec<String> {
    let name = |cell: &Cell| format!("{}: {} ({})", result.case, cell.technique, cell.settings);
    let of = |cell: &Cell| match (&cell.outcome, cell.disagreeing) {
        (CellOutcome::Fault { what }, _) => Some(format!("{}: {what}", name(cell))),
        (_, Some(n)) if n > 0 => Some(format!(
            "{}: backends differ on {n} decided pixels",
            name(cell)
        )),
        _ => None,
    };
    result.cells.iter().filter_map(of).collect()
}

/// Compares backends that have played with fresh ones, by kind: a fault for each that gives another picture.
///
/// # Errors
/// When a control can't be played.
pub fn check_state(
    used: &mut [Box<dyn Backend>],
    fresh: &mut [Box<dyn Backend>],
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
