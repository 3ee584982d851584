//! Bias from none to too much: acne falls, and what shadows lose grows.
//!
//! Both are drawn in units of their own limits, so that one chart holds them: below 1 either passes. The best bias is the
//! one at which the worse of the two is least.

use super::{Curve, Sweep, not_played, play};
use crate::{
    LabError,
    compare::Backends,
    stability::{
        CaseTruth, Measure, PLATE, StabilityCase, StabilityOptions,
        all_backends::{self, RenderedOnAll},
        case_truth,
        guard::NoMask,
    },
};
use umbrage_core::RasterBias;
use umbrage_techniques::{Bias, Hard, ShadowMap};

/// A scene and a kind of bias.
#[derive(Debug)]
pub(super) struct Kind {
    pub(super) name: &'static str,
    title: &'static str,
    scene: &'static str,
    x: &'static str,
    /// Beside acne.
    loss: Measure,
    /// From next to nothing to far too much.
    range: [f32; 2],
    bias: fn(f32) -> Bias,
}

/// Steps between the ends of a range, both included.
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

const fn kind(name: &'static str, scene: &'static str, loss: Measure) -> Kind {
    let x = "normal offset, texels";
    Kind {
        name,
        title: "",
        scene,
        x,
        loss,
        range: [0.02, 50.0],
        bias: normal_offset,
    }
}

#[rustfmt::skip]
pub(super) const ALL: &[Kind] = &[
    Kind { title: "thin-plate: constant bias", x: "constant bias, clip depth", range: [1e-5, 0.3], bias: constant,
           ..kind("bias-constant", "thin-plate", Measure::Gap(PLATE)) },
    Kind { title: "thin-plate: polygon offset", x: "polygon offset, slope factor", bias: polygon_offset,
           ..kind("bias-polygon-offset", "thin-plate", Measure::Gap(PLATE)) },
    Kind { title: "thin-plate: normal offset", ..kind("bias-normal-offset", "thin-plate", Measure::Gap(PLATE)) },
    Kind { title: "low-sun-5: normal offset", ..kind("bias-low-sun", "low-sun-5", Measure::Rmse) },
    Kind { title: "stairs: normal offset", ..kind("bias-stairs", "stairs", Measure::Rmse) },
];

pub(super) fn sweep(
    kind: &Kind,
    options: &StabilityOptions,
    backends: &mut Backends,
) -> Result<Sweep, LabError> {
    let case_truth = case_truth(
        &StabilityCase::still(kind.scene, kind.loss),
        kind.scene,
        options,
    )?;
    let values: Vec<f32> = (0..STEPS)
        .map(|i| geometric_step(kind.range[0], kind.range[1], i))
        .collect();
    let played = masks(kind, &values, &case_truth, options, backends)?;
    let curve = |measure: Measure| {
        let pass = measure.limits(&case_truth).pass;
        let points = values
            .iter()
            .zip(&played)
            .map(|(v, p)| [f64::from(*v), measure.figure(&case_truth, &p.mask) / pass]);
        Curve {
            label: format!("{} (limit {})", measure.name(), limit(pass, measure.unit())),
            points: points.collect(),
        }
    };
    let curves = vec![curve(Measure::Acne), curve(kind.loss)];
    let best = best(&curves);
    Ok(Sweep {
        name: kind.name.to_owned(),
        title: kind.title.to_owned(),
        x: kind.x.to_owned(),
        y: "times the limit that passes".to_owned(),
        curves,
        best,
        limit: Some(1.0),
        disagreeing: played
            .iter()
            .map(|p| p.disagreeing)
            .fold(None, all_backends::sum),
    })
}

fn limit(pass: f64, unit: &str) -> String {
    format!("{pass:.3} {unit}").trim_end().to_owned()
}

/// Returns value `i` of [`STEPS`] from `from` to `to`, each greater than the one before by the same factor.
fn geometric_step(from: f32, to: f32, i: u32) -> f32 {
    let t = i as f32 / (STEPS - 1) as f32;
    from * (to / from).powf(t)
}

fn masks(
    kind: &Kind,
    values: &[f32],
    case_truth: &CaseTruth,
    options: &StabilityOptions,
    backends: &mut Backends,
) -> Result<Vec<RenderedOnAll>, LabError> {
    let one = |(i, v): (usize, &f32)| {
        let map = ShadowMap {
            size: options.map_size,
            bias: (kind.bias)(*v),
            ..ShadowMap::default()
        };
        match play(case_truth, &Hard { map }, backends, i, values.len()) {
            // A perfect score, or a gap that nobody sees, would hide that hard shadows are not served.
            Err(NoMask::Unsupported(why) | NoMask::Fault(why)) => {
                Err(not_played(case_truth, &Hard { map }, &why))
            }
            Ok(played) => Ok(played),
        }
    };
    values.iter().enumerate().map(one).collect()
}

/// Where the worst curve is lowest; the least such x.
fn best(curves: &[Curve]) -> Option<f64> {
    let points = curves.first()?.points.len();
    let worst = |i: usize| curves.iter().map(|c| c.points[i][1]).fold(0.0, f64::max);
    let i = (0..points).min_by(|a, b| worst(*a).total_cmp(&worst(*b)))?;
    Some(curves[0].points[i][0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::faulty_backend::{FaultyBackend, darken_one};
    use umbrage_core::{Backend, BackendError, Invalid, Recipe, Shadows, View};
    use umbrage_cpu::Cpu;

    fn on(playing: Vec<Box<dyn Backend>>) -> Result<Sweep, LabError> {
        sweep(
            &ALL[0],
            &StabilityOptions::quick(),
            &mut Backends::of(playing),
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
        let sweep = on(vec![Box::new(Cpu::new())]).expect("valid");
        let [acne, gap] = &sweep.curves[..] else {
            panic!("two curves")
        };
        let ends = |c: &Curve| [c.points[0][1], c.points[c.points.len() - 1][1]];
        let ([acne_least, acne_most], [gap_least, gap_most]) = (ends(acne), ends(gap));
        assert!(
            acne_least > 10.0 && acne_most == 0.0,
            "acne {acne_least} to {acne_most}"
        );
        assert!(
            gap_least <= 1.0 && gap_most > 4.0,
            "gap {gap_least} to {gap_most}"
        );
    }

    #[test]
    fn ends_and_middle_play_on_every_backend() {
        let beside = |k: usize| {
            let mut played = 0;
            let cheat = FaultyBackend::new(move |shadows: &mut Shadows| {
                played += 1;
                if played == k {
                    darken_one(shadows);
                }
            });
            on(vec![Box::new(Cpu::new()), Box::new(cheat)]).expect("valid")
        };
        // The last of three, and one that never comes.
        for (k, disagreeing) in [(3, 1), (4, 0)] {
            let sweep = beside(k);
            assert_eq!(
                (sweep.disagreeing, sweep.fault().is_some()),
                (Some(disagreeing), disagreeing > 0),
                "{k}"
            );
        }
    }

    /// What isn't served has no figure, least of all a perfect one.
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
        let why = on(vec![Box::new(Refuses)])
            .expect_err("nothing is served")
            .to_string();
        assert!(
            why.contains("thin-plate") && why.contains("hard") && why.contains("too large"),
            "{why}"
        );
    }
}
