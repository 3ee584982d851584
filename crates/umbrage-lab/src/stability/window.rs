//! Bias windows: the range of biases at which a technique has neither acne nor a gap.
//!
//! A technique's bias is increased by a normal offset, from nothing to far too much. Too little
//! causes acne under a low sun; too much detaches the shadow of a thin plate and loses shadow. The
//! window is the widest run of offsets that pass both cases by all of their criteria. Its width in
//! texels is the tolerance of a guess.
//!
//! Under [`Base::Own`] the technique keeps its default bias: a window that starts at 0 needs no
//! tuning. Under [`Base::Bare`] the offset is the only bias.

use super::{
    all_backends,
    bias_window::{Base, BiasWindow, GREATEST},
    case_truth::CaseTruth,
    cell::Stability,
    criterion::Criterion,
    guard::NoMask,
    measure::Measure,
    row::StabilityCase,
    rows::PLATE,
    run::{StabilityOptions, case_truth, some_backend},
    sweeps::curve::{render_point, sweep_error},
    threads::{self, SharedBackends},
    verdict::Verdict,
};
use crate::{compare::Backends, error::LabError};
use std::sync::{Mutex, PoisonError};
use umbrage_core::ShadowTechnique;
use umbrage_techniques::{Bias, ShadowMap, TechniquePreset};

/// Number of tested offsets besides 0, each 1.2 times the one before. A window between two of them
/// is not found.
const STEPS: u32 = 33;
/// Number of bisections between the last passing offset and the next: to a hundredth of the offset.
const HALVINGS: u32 = 4;
/// Least offset besides 0, texels: what rounding alone may need.
const LEAST: f64 = 0.05;
/// Constant bias besides a normal offset, clip depth: the rounding of depths.
const ROUNDING: f32 = 1e-5;

/// Cases for too much bias, and for too little.
const CASES: [StabilityCase; 2] = [
    StabilityCase::still("thin-plate", Measure::Gap(PLATE)),
    StabilityCase::still("low-sun-5", Measure::Acne),
];

impl Stability {
    /// Summarizes the bias windows in one or two sentences: which techniques need no tuning, some
    /// tuning or can't be tuned, and which window is the widest. `None` without windows.
    pub fn windows_line(&self) -> Option<String> {
        let own = || self.windows.iter().filter(|w| w.base == Base::Own);
        let named = |wanted: &dyn Fn(&BiasWindow) -> bool| {
            let names: Vec<&str> = own()
                .filter(|w| wanted(w))
                .map(|w| &w.technique[..])
                .collect();
            names.join(", ")
        };
        let widest = own().max_by(|a, b| a.width().total_cmp(&b.width()))?;
        let mut parts = Vec::new();
        for (names, what) in [
            (named(&|w| w.needs_no_tuning()), "need no tuning"),
            (
                named(&|w| !w.needs_no_tuning() && w.passes.is_some()),
                "need some",
            ),
            (
                named(&|w| !w.needs_no_tuning() && w.passes.is_none()),
                "fail with any amount",
            ),
        ] {
            if !names.is_empty() {
                parts.push(format!("{what}: {names}"));
            }
        }
        if widest.width() > 0.0 {
            let (name, words) = (&widest.technique, widest.words());
            parts.push(format!("widest window: {name}, {words}"));
        }
        Some(parts.join("; "))
    }
}

/// Returns the windows of all selected techniques with a map, with both bases of each. They are
/// sorted by width under the technique's own bias, widest first. Techniques that don't support both
/// cases are omitted.
///
/// # Errors
/// Errors if there is no backend, a scene can't be used, or a technique's result breaks the rules
/// (a panic, values outside 0..=1).
pub fn windows(
    options: &StabilityOptions,
    backends: &mut Backends,
    on_technique: &mut (dyn FnMut(&str) + Send),
) -> Result<Vec<BiasWindow>, LabError> {
    some_backend(backends)?;
    // Trace truth for both cases.
    let mut stages = Vec::new();
    for case in &CASES {
        stages.push(WindowCase::new(case, options)?);
    }
    // Collect the selected techniques that have a map.
    let mut presets = Vec::new();
    for entry in options.catalogue.select(&options.techniques)? {
        let preset = (entry.technique.preset)();
        let Some(map) = preset.map().copied() else {
            continue;
        };
        let map = ShadowMap {
            size: options.map_size,
            ..map
        };
        presets.push((entry.technique.name, preset, map));
    }
    // Find the windows in parallel, and sort them by width.
    let backends = SharedBackends::new(backends);
    let on_technique = Mutex::new(on_technique);
    let windows = threads::map(&presets, |(name, preset, map)| {
        on_technique.lock().unwrap_or_else(PoisonError::into_inner)(name);
        let mut both = Vec::new();
        for base in [Base::Own, Base::Bare] {
            both.extend(window(preset, *map, base, &stages, &backends)?);
        }
        Ok::<_, LabError>(both)
    });
    let mut by_technique = windows.into_iter().collect::<Result<Vec<_>, _>>()?;
    let own_width = |windows: &Vec<BiasWindow>| windows.first().map_or(0.0, BiasWindow::width);
    by_technique.sort_by(|a, b| own_width(b).total_cmp(&own_width(a)));
    Ok(by_technique.concat())
}

/// A case with its truth.
struct WindowCase {
    case_truth: CaseTruth,
    criteria: Vec<Criterion>,
}

impl WindowCase {
    fn new(case: &StabilityCase, options: &StabilityOptions) -> Result<Self, LabError> {
        let case_truth = case_truth(case, case.scene, options)?;
        let criteria = Criterion::of_case(case.measure, &case_truth, |m| m.limits(&case_truth));
        Ok(Self {
            case_truth,
            criteria,
        })
    }

    /// Reports whether a mask passes all criteria.
    fn passes(&self, mask: &[f32]) -> bool {
        self.criteria.iter().all(|criterion| {
            let figure = criterion.measure.figure(&self.case_truth, mask);
            criterion.limits.judge(figure) == Verdict::Pass
        })
    }
}

/// Returns the tested offsets, texels, increasing from 0.
fn amounts() -> Vec<f64> {
    let mut out = vec![0.0];
    for i in 0..STEPS {
        let t = f64::from(i) / f64::from(STEPS - 1);
        out.push(LEAST * (GREATEST / LEAST).powf(t));
    }
    out
}

/// Returns a bias with an additional normal offset.
fn offset_by(own: Bias, base: Base, amount: f64) -> Bias {
    match base {
        Base::Own => Bias {
            normal_offset: own.normal_offset + amount as f32,
            ..own
        },
        Base::Bare => Bias {
            normal_offset: amount as f32,
            constant: ROUNDING,
            cull: own.cull,
            ..Bias::NONE
        },
    }
}

/// Returns a technique's window on such maps; `None` if it doesn't support a case.
fn window(
    preset: &TechniquePreset,
    map: ShadowMap,
    base: Base,
    stages: &[WindowCase],
    backends: &SharedBackends<'_>,
) -> Result<Option<BiasWindow>, LabError> {
    let mut trial = Trial {
        preset,
        map,
        base,
        stages,
        disagreeing: None,
    };
    // Test all offsets.
    let amounts = amounts();
    let mut passing = Vec::new();
    for (i, &amount) in amounts.iter().enumerate() {
        match trial.passes(amount, i, amounts.len(), backends)? {
            Some(passes) => passing.push(passes),
            None => return Ok(None),
        }
    }
    // Refine the ends of the widest passing run.
    let mut ends = widest_run(&amounts, &passing);
    if let Some([from, to]) = &mut ends {
        let before = amounts.iter().copied().rfind(|amount| amount < from);
        let after = amounts.iter().copied().find(|amount| amount > to);
        *from = trial.last_passing(*from, before, backends)?;
        *to = trial.last_passing(*to, after, backends)?;
    }
    let unbiased = trial.technique(0.0);
    Ok(Some(BiasWindow {
        technique: unbiased.name().to_owned(),
        settings: unbiased.settings(),
        base,
        passes: ends,
        passes_without: passing.first() == Some(&true),
        disagreeing: trial.disagreeing,
    }))
}

/// A technique that is tested with one offset after the other.
struct Trial<'a> {
    preset: &'a TechniquePreset,
    map: ShadowMap,
    base: Base,
    stages: &'a [WindowCase],
    /// [`BiasWindow::disagreeing`] so far.
    disagreeing: Option<u64>,
}

impl Trial<'_> {
    /// Returns the technique with this offset.
    fn technique(&self, amount: f64) -> TechniquePreset {
        let bias = offset_by(self.map.bias, self.base, amount);
        let map = ShadowMap { bias, ..self.map };
        self.preset.with_map(map)
    }

    /// Reports whether offset `i` of `count` passes all cases; `None` if one isn't supported.
    fn passes(
        &mut self,
        amount: f64,
        i: usize,
        count: usize,
        backends: &SharedBackends<'_>,
    ) -> Result<Option<bool>, LabError> {
        let technique = self.technique(amount);
        for stage in self.stages {
            let rendered = match render_point(&stage.case_truth, &technique, backends, i, count) {
                Ok(rendered) => rendered,
                Err(NoMask::Unsupported(_)) => return Ok(None),
                Err(NoMask::Fault(what)) => {
                    return Err(sweep_error(&stage.case_truth, &technique, &what));
                }
            };
            self.disagreeing = all_backends::sum(self.disagreeing, rendered.disagreeing);
            // Skip the other case after a failure.
            if !stage.passes(&rendered.mask) {
                return Ok(Some(false));
            }
        }
        Ok(Some(true))
    }

    /// Returns the last passing offset between a passing one and a failing neighbour, by bisection;
    /// the passing one if there is no neighbour.
    fn last_passing(
        &mut self,
        passing: f64,
        failing: Option<f64>,
        backends: &SharedBackends<'_>,
    ) -> Result<f64, LabError> {
        let Some(mut failing) = failing else {
            return Ok(passing);
        };
        let mut passing = passing;
        for _ in 0..HALVINGS {
            let middle = 0.5 * (passing + failing);
            // Index 1 of 4 runs only the first backend.
            if self.passes(middle, 1, 4, backends)? == Some(true) {
                passing = middle;
            } else {
                failing = middle;
            }
        }
        Ok(passing)
    }
}

/// Returns the ends of the widest run of passing neighbours, the first of equally wide ones; `None`
/// without any. Offsets increase.
fn widest_run(amounts: &[f64], passing: &[bool]) -> Option<[f64; 2]> {
    let mut widest: Option<[f64; 2]> = None;
    let mut run: Option<[f64; 2]> = None;
    for (&amount, &passes) in amounts.iter().zip(passing) {
        run = match (passes, run) {
            (false, _) => None,
            (true, None) => Some([amount, amount]),
            (true, Some([from, _])) => Some([from, amount]),
        };
        let Some([from, to]) = run else {
            continue;
        };
        if widest.is_none_or(|[first, last]| to - from > last - first) {
            widest = run;
        }
    }
    widest
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage_cpu::Cpu;

    #[test]
    fn the_widest_run_is_the_window() {
        let amounts = [0.0, 1.0, 2.0, 4.0, 8.0];
        let run = |passing: [bool; 5]| widest_run(&amounts, &passing);
        assert_eq!(run([false; 5]), None);
        assert_eq!(run([true; 5]), Some([0.0, 8.0]));
        assert_eq!(run([false, true, false, true, true]), Some([4.0, 8.0]));
        assert_eq!(run([true, true, false, true, false]), Some([0.0, 1.0]));
        assert_eq!(run([false, false, true, false, false]), Some([2.0, 2.0]));
    }

    /// One bare comparison needs an offset, but the default bias needs none. Far too much passes
    /// under neither.
    #[test]
    fn a_bare_comparison_needs_tuning_and_the_default_does_not() {
        let options = StabilityOptions {
            techniques: vec!["hard".to_owned(), "traced".to_owned()],
            ..StabilityOptions::quick()
        };
        let mut backends = Backends::from_backends(vec![Box::new(Cpu::new())]);
        let windows = windows(&options, &mut backends, &mut |_| {}).expect("runs");
        let [own, bare] = &windows[..] else {
            panic!("rays have no bias: {windows:?}");
        };
        assert_eq!([own.base, bare.base], [Base::Own, Base::Bare]);
        assert!(own.needs_no_tuning() && own.width() > 0.0, "{own:?}");
        assert!(!bare.needs_no_tuning() && bare.width() > 0.0, "{bare:?}");
        for window in &windows {
            let [_, most] = window.passes.expect("some pass");
            assert!(most < GREATEST, "{window:?}");
        }
    }

    #[test]
    fn windows_read_as_words() {
        let window = |passes| BiasWindow {
            technique: "hard".to_owned(),
            settings: String::new(),
            base: Base::Own,
            passes,
            passes_without: passes.is_some_and(|[from, _]: [f64; 2]| from == 0.0),
            disagreeing: Some(3),
        };
        assert_eq!(window(Some([0.0, 1.93])).words(), "0 to 1.9 texels");
        assert_eq!(
            window(Some([0.35, GREATEST])).words(),
            "0.35 texels and more"
        );
        assert_eq!(window(None).words(), "no amount passes");
        assert_eq!(window(None).width(), 0.0);
        assert!(
            window(None)
                .fault()
                .is_some_and(|f| f.contains("3 decided"))
        );
    }
}
