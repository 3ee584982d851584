//! Tests of a driver that rounds differently from the CPU. `cargo xtask test` runs them on
//! SwiftShader; manually, they run on the adapter of `WGPU_ADAPTER_NAME`.

use glam::UVec2;
use umbrage_core::{Backend, BackendError, Recipe, Shadows, Snapping, View};
use umbrage_cpu::Cpu;
use umbrage_lab::{
    compare::{Backends, CompareOptions, Comparison, SceneInput, compare},
    stability,
};
use umbrage_plan::truth::TruthOptions;
use umbrage_tests::{
    driver_model::{DriverModel, is_chosen, nth_case, runs_all_cases},
    gpu::adapter_by_name,
};
use umbrage_wgpu::Gpu;

/// The CPU and the driver.
fn backends() -> Backends {
    DriverModel::install();
    let adapter = adapter_by_name().expect(
        "these tests are for an adapter by name: run `cargo xtask test`, or set WGPU_ADAPTER_NAME",
    );
    Backends::both(&adapter).unwrap_or_else(|why| panic!("{why}"))
}

/// Compares images that are small enough for the suite to take seconds, and large enough for single
/// pixels to have little weight in the RMSE. Empty lists mean the suite's scenes, and all techniques.
fn compare_scenes(scenes: &[&str], techniques: &[&str], backends: &mut Backends) -> Comparison {
    let wanted = |e: &&umbrage_scenes::SceneEntry| {
        if scenes.is_empty() {
            e.suite
        } else {
            scenes.contains(&e.name)
        }
    };
    let input = |e: &umbrage_scenes::SceneEntry| SceneInput {
        fit: e.fit,
        ..SceneInput::new((e.build)(), "")
    };
    let inputs: Vec<SceneInput> = umbrage_scenes::all()
        .iter()
        .filter(wanted)
        .enumerate()
        .filter(|(i, _)| is_chosen(*i))
        .map(|(_, entry)| input(entry))
        .collect();
    let truth = TruthOptions {
        samples: 16,
        probe_samples: 8,
        penumbra_factor: 1,
        ..TruthOptions::default()
    };
    let options = CompareOptions {
        techniques: techniques.iter().map(|&name| name.to_owned()).collect(),
        truth,
        runs: None,
        max_settings: Some(2),
        ..CompareOptions::quick()
    };
    compare(&inputs, &options, backends, &mut |_, _| Ok(()), &|_| {}).expect("comparable")
}

/// No decided pixel differs, few are undecided, and no mask's error exceeds the CPU's by more than
/// .005.
#[test]
fn the_suite_agrees_on_the_second_driver() {
    let mut backends = backends();
    let comparison = compare_scenes(&[], &[], &mut backends);
    let rows = comparison.scenes.iter().flat_map(|scene| &scene.rows);
    let agreed = rows
        .filter(|row| {
            row.measured_figures()
                .is_some_and(|m| m.agreement.is_some())
        })
        .count();
    assert!(
        agreed > 400 / nth_case(),
        "only {agreed} rows were compared"
    );
    let faults: Vec<String> = comparison
        .faults()
        .into_iter()
        .filter(|fault| !is_known(fault))
        .collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// Reports whether an error is known. In a room with walls without thickness, the far sides of
/// second depths are the receivers themselves, without a bias. Half of the pixels are lit in this
/// way, and the selection depends on rounding.
fn is_known(fault: &str) -> bool {
    fault.starts_with("c7-closed-room: second_depth") && fault.contains("RMSE is 0.00")
}

/// The catalogue of failures in small images: both backends fail the same rows, on the same pixels.
#[test]
fn failure_rows_agree_on_the_second_driver() {
    let truth = TruthOptions {
        samples: 16,
        penumbra_factor: 1,
        probe_samples: 8,
        ..TruthOptions::default()
    };
    let small = stability::StabilityOptions {
        size: UVec2::new(96, 72),
        map_size: 256,
        frames: 2,
        truth,
        rows: chosen_cases(),
        ..Default::default()
    };
    let rendered = stability::run(&small, &mut backends(), &mut |_| {}).expect("renders");
    assert!(
        rendered.cases.len() >= 30 / nth_case(),
        "only {} cases were run",
        rendered.cases.len()
    );
    assert!(rendered.faults.is_empty(), "{}", rendered.faults.join("\n"));
}

/// Returns the names of the cases that run. An empty list means all of them.
fn chosen_cases() -> Vec<String> {
    if runs_all_cases() {
        return Vec::new();
    }
    let cases = stability::cases().map(|(_, case)| case.name.to_owned());
    let chosen = cases.enumerate().filter(|(i, _)| is_chosen(*i));
    chosen.map(|(_, name)| name).collect()
}

/// A backend that reports a different grid from its driver's.
struct MisreportingBackend(Gpu);

impl Backend for MisreportingBackend {
    fn name(&self) -> &str {
        self.0.name()
    }
    fn kind(&self) -> &'static str {
        self.0.kind()
    }
    fn snapping(&self) -> Snapping {
        if self.0.snapping() == Snapping::COARSEST {
            Snapping::default()
        } else {
            Snapping::COARSEST
        }
    }
    fn render(&mut self, view: &View<'_>, recipe: &Recipe) -> Result<Shadows, BackendError> {
        self.0.render(view, recipe)
    }
}

/// Negative control: a wrong grid must be detected.
#[test]
fn a_wrong_grid_is_noticed_on_the_second_driver() {
    let gpu = Gpu::new(&adapter_by_name().expect("as above")).expect("an adapter");
    let mut backends = Backends::from_backends(vec![
        Box::new(Cpu::new()),
        Box::new(MisreportingBackend(gpu)),
    ]);
    let faults = compare_scenes(&["cubes"], &["hard"], &mut backends).faults();
    // With a finer grid than the driver's, decided pixels differ. With a coarser one, too many
    // pixels are undecided.
    let is_of_grid = |fault: &String| {
        fault.contains("decided pixels differ") || fault.contains("rounding alone")
    };
    assert!(
        faults.iter().any(is_of_grid),
        "the wrong grid is not detected: {faults:?}"
    );
}
