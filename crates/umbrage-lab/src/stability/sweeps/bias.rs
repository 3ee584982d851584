//! Bias from almost none to far too much: acne falls, and the cost of the bias (a gap at contacts,
//! or RMSE) grows.
//!
//! Both are drawn in one chart, in units of their own limits: each passes up to 1. The best bias
//! minimises the worse of the two.

use super::curve::{Curve, Sweep, render_point, sweep_error};
use crate::{
    error::LabError,
    stability::{
        all_backends::{self, RenderedOnAll},
        case_truth::CaseTruth,
        guard::NoMask,
        measure::Measure,
        row::StabilityCase,
        rows::PLATE,
        run::{StabilityOptions, case_truth},
        threads::{self, SharedBackends},
    },
};
use umbrage_core::RasterBias;
use umbrage_techniques::{Bias, Hard, MapFilter as _, ShadowMap};

/// A scene and a kind of bias.
#[derive(Debug)]
pub(super) struct BiasSweep {
    /// Name for files.
    pub(super) name: &'static str,
    title: &'static str,
    /// Name of a built-in scene.
    scene: &'static str,
    /// Label of the x axis, with its unit.
    x: &'static str,
    /// Measure that too much bias worsens: the second curve.
    loss: Measure,
    /// First value, almost no bias.
    from: f32,
    /// Last value, far too much.
    to: f32,
    /// Converts a value to a bias.
    bias: fn(f32) -> Bias,
}

/// Number of values of a sweep, including its ends.
const STEPS: u32 = 25;

fn constant(v: f32) -> Bias {
    Bias {
        constant: v,
        ..Bias::NONE
    }
}

fn polygon_offset(v: f32) -> Bias {
    Bias {
        raster: RasterBias {
            constant: 4,
            slope: v,
            clamp: 0.0,
        },
        ..Bias::NONE
    }
}

fn normal_offset(v: f32) -> Bias {
    Bias {
        normal_offset: v,
        constant: 1e-5,
        ..Bias::NONE
    }
}

/// Returns a sweep of the normal offset; the list below overrides its fields.
const fn kind(name: &'static str, scene: &'static str, loss: Measure) -> BiasSweep {
    BiasSweep {
        name,
        title: "",
        scene,
        x: "normal offset, texels",
        loss,
        from: 0.02,
        to: 50.0,
        bias: normal_offset,
    }
}

pub(super) const ALL: &[BiasSweep] = &[
    BiasSweep {
        title: "thin-plate: constant bias",
        x: "constant bias, clip depth",
        from: 1e-5,
        to: 0.3,
        bias: constant,
        ..kind("bias-constant", "thin-plate", Measure::Gap(PLATE))
    },
    BiasSweep {
        title: "thin-plate: polygon offset",
        x: "polygon offset, slope factor",
        bias: polygon_offset,
        ..kind("bias-polygon-offset", "thin-plate", Measure::Gap(PLATE))
    },
    BiasSweep {
        title: "thin-plate: normal offset",
        ..kind("bias-normal-offset", "thin-plate", Measure::Gap(PLATE))
    },
    BiasSweep {
        title: "low-sun-5: normal offset",
        ..kind("bias-low-sun", "low-sun-5", Measure::Rmse)
    },
    BiasSweep {
        title: "stairs: normal offset",
        ..kind("bias-stairs", "stairs", Measure::Rmse)
    },
];

pub(super) fn sweep(
    kind: &BiasSweep,
    options: &StabilityOptions,
    backends: &SharedBackends<'_>,
) -> Result<Sweep, LabError> {
    let case_truth = case_truth(
        &StabilityCase::still(kind.scene, kind.loss),
        kind.scene,
        options,
    )?;
    let values: Vec<f32> = (0..STEPS)
        .map(|i| geometric_step(kind.from, kind.to, i))
        .collect();
    let executed = masks(kind, &values, &case_truth, options, backends)?;
    let curves = vec![
        curve(Measure::Acne, &values, &executed, &case_truth),
        curve(kind.loss, &values, &executed, &case_truth),
    ];
    let best = best(&curves);
    Ok(Sweep {
        name: kind.name.to_owned(),
        title: kind.title.to_owned(),
        x: kind.x.to_owned(),
        y: "multiple of the passing limit".to_owned(),
        curves,
        best,
        limit: Some(1.0),
        disagreeing: executed
            .iter()
            .map(|p| p.disagreeing)
            .fold(None, all_backends::sum),
    })
}

/// Returns the curve of a measure, in units of its passing limit.
fn curve(
    measure: Measure,
    values: &[f32],
    executed: &[RenderedOnAll],
    case_truth: &CaseTruth,
) -> Curve {
    let pass = measure.limits(case_truth).pass;
    let mut points = Vec::new();
    for (value, rendered) in values.iter().zip(executed) {
        let figure = measure.figure(case_truth, &rendered.mask);
        points.push([f64::from(*value), figure / pass]);
    }
    Curve {
        label: format!("{} (limit {})", measure.name(), limit(pass, measure.unit())),
        points,
    }
}

fn limit(pass: f64, unit: &str) -> String {
    format!("{pass:.3} {unit}").trim_end().to_owned()
}

/// Returns value `i` of [`STEPS`] from `from` to `to`, in geometric steps.
fn geometric_step(from: f32, to: f32, i: u32) -> f32 {
    let t = i as f32 / (STEPS - 1) as f32;
    from * (to / from).powf(t)
}

/// Renders hard shadows with each value's bias.
fn masks(
    kind: &BiasSweep,
    values: &[f32],
    case_truth: &CaseTruth,
    options: &StabilityOptions,
    backends: &SharedBackends<'_>,
) -> Result<Vec<RenderedOnAll>, LabError> {
    let places: Vec<usize> = (0..values.len()).collect();
    let executed = threads::map(&places, |&i| {
        let map = ShadowMap {
            size: options.map_size,
            bias: (kind.bias)(values[i]),
            ..ShadowMap::default()
        };
        let executed = render_point(case_truth, &Hard {}.on(map), backends, i, values.len());
        // Return an error without a mask: omitting the point would hide that the setting has none.
        executed.map_err(|(NoMask::Unsupported(why) | NoMask::Fault(why))| {
            sweep_error(case_truth, &Hard {}.on(map), &why)
        })
    });
    executed.into_iter().collect()
}

/// Returns the x at which the greatest of the curves is least; the smallest such x.
fn best(curves: &[Curve]) -> Option<f64> {
    let points = curves.first()?.points.len();
    let best = (0..points).min_by(|&a, &b| highest(curves, a).total_cmp(&highest(curves, b)))?;
    Some(curves[0].points[best][0])
}

/// Returns the greatest y of all curves at point `i`.
fn highest(curves: &[Curve], i: usize) -> f64 {
    curves.iter().map(|c| c.points[i][1]).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        compare::Backends,
        faulty_backend::{FaultyBackend, darken_one},
    };
    use umbrage_core::{Backend, BackendError, Invalid, Recipe, Shadows, View};
    use umbrage_cpu::Cpu;

    /// Runs the first sweep on these backends.
    fn sweep_on(own_backends: Vec<Box<dyn Backend + Send>>) -> Result<Sweep, LabError> {
        sweep(
            &ALL[0],
            &StabilityOptions::quick(),
            &SharedBackends::new(&mut Backends::from_backends(own_backends)),
        )
    }

    #[test]
    fn the_best_is_between_acne_and_gap() {
        let falling = Curve {
            label: String::new(),
            points: vec![[1.0, 9.0], [2.0, 3.0], [4.0, 0.0], [8.0, 0.0]],
        };
        let rising = Curve {
            label: String::new(),
            points: vec![[1.0, 0.0], [2.0, 0.5], [4.0, 1.0], [8.0, 7.0]],
        };
        assert_eq!(best(&[falling, rising]), Some(4.0));
    }

    #[test]
    fn acne_falls_and_the_gap_grows() {
        let sweep = sweep_on(vec![Box::new(Cpu::new())]).expect("valid");
        let [acne, gap] = &sweep.curves[..] else {
            panic!("two curves")
        };
        let last = acne.points.len() - 1;
        let acne_at_least_bias = acne.points[0][1];
        let acne_at_most_bias = acne.points[last][1];
        assert!(
            acne_at_least_bias > 10.0 && acne_at_most_bias == 0.0,
            "acne {acne_at_least_bias} to {acne_at_most_bias}"
        );
        let gap_at_least_bias = gap.points[0][1];
        let gap_at_most_bias = gap.points[last][1];
        assert!(
            gap_at_least_bias <= 1.0 && gap_at_most_bias > 4.0,
            "gap {gap_at_least_bias} to {gap_at_most_bias}"
        );
    }

    #[test]
    fn ends_and_middle_run_on_every_backend() {
        // A fault in the last of three renderings is noticed. There is no fourth one.
        let faulty_third = sweep_with_faulty(3);
        assert_eq!(faulty_third.disagreeing, Some(1));
        assert!(faulty_third.fault().is_some());
        let faulty_fourth = sweep_with_faulty(4);
        assert_eq!(faulty_fourth.disagreeing, Some(0));
        assert_eq!(faulty_fourth.fault(), None);
    }

    /// Runs a sweep on the CPU and on a backend whose `k`-th rendering has one wrong pixel.
    fn sweep_with_faulty(k: usize) -> Sweep {
        let mut executed = 0;
        let faulty = FaultyBackend::new(move |shadows: &mut Shadows| {
            executed += 1;
            if executed == k {
                darken_one(shadows);
            }
        });
        sweep_on(vec![Box::new(Cpu::new()), Box::new(faulty)]).expect("valid")
    }

    /// A setting that can't be rendered has no figure, least of all a perfect one.
    #[test]
    fn a_bias_that_is_not_served_is_an_error() {
        struct Refuses;
        impl Backend for Refuses {
            fn name(&self) -> &str {
                "refuses"
            }
            fn kind(&self) -> &'static str {
                "cpu"
            }
            fn render(&mut self, _: &View<'_>, _: &Recipe) -> Result<Shadows, BackendError> {
                Err(Invalid::new("map", "is too large", "use a smaller one").into())
            }
        }
        let why = sweep_on(vec![Box::new(Refuses)])
            .expect_err("nothing is supported")
            .to_string();
        assert!(
            why.contains("thin-plate") && why.contains("hard") && why.contains("too large"),
            "{why}"
        );
    }
}
