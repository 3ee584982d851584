//! The curve that proves a bias, as a picture.

use crate::output::figure::{Figure, Marker, Point, Series, Style};
use umbrage_plan::{BiasKind, CurvePoint, Estimate, Plan};

/// The kinds of bias that have amounts, with colours that are told apart in black and white, too.
const KINDS: [(BiasKind, &str); 3] = [
    (BiasKind::NormalOffset, "#3b82e0"),
    (BiasKind::Adaptive, "#ea7317"),
    (BiasKind::PolygonOffset, "#5b6472"),
];

/// Error against bias for the chosen setting: what is too dark (acne) falls, what is too light (the gap) grows, and the
/// marked amount leaves the least of both. None for techniques without a bias to find, and where nothing was chosen.
pub fn curve_figure(plan: &Plan) -> Option<Figure> {
    let chosen = plan.chosen.as_ref().filter(|_| !plan.curve.is_empty())?;
    let title = format!("The best bias of {}: {}", plan.scene, chosen.technique);
    let mut figure = Figure::new(
        title,
        "bias, texels",
        "error (root mean square of visibility)",
    );
    figure.subtitle.clone_from(&chosen.settings);
    for (kind, color) in KINDS {
        let of = |value: fn(&Estimate) -> f64| points(&plan.curve, |p| p.kind == kind, value);
        if of(|e| e.error).is_empty() {
            continue;
        }
        let part = |name: &str, value, style| Series {
            style,
            ..Series::line(format!("{}: {name}", kind.name()), color, of(value))
        };
        figure
            .series
            .push(part("all", |e| e.error, Style::Line(2.5)));
        figure
            .series
            .push(part("acne (too dark)", |e| e.too_dark, Style::Dashed(1.5)));
        figure
            .series
            .push(part("gap (too light)", |e| e.too_light, Style::Line(0.8)));
    }
    let best = points(&plan.curve, |p| p.chosen, |e| e.error);
    Some(figure.with(Series::points("chosen", "#c0392b", Marker::Star, best)))
}

fn points(
    curve: &[CurvePoint],
    keep: impl Fn(&CurvePoint) -> bool,
    value: fn(&Estimate) -> f64,
) -> Vec<Point> {
    curve
        .iter()
        .filter(|p| keep(p))
        .map(|p| Point::at(f64::from(p.texels), value(&p.estimate)))
        .collect()
}
