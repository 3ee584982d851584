//! Draws the curve of error against bias from which a plan chose its bias.

use crate::output::figure::{Figure, Marker, Point, Series, Style};
use umbrage_plan::{BiasKind, CurvePoint, Estimate, Plan};

/// Kinds of bias with an amount, each with a colour. The colours also differ in lightness.
const KINDS: [(BiasKind, &str); 3] = [
    (BiasKind::NormalOffset, "#3b82e0"),
    (BiasKind::Adaptive, "#ea7317"),
    (BiasKind::PolygonOffset, "#5b6472"),
];

/// Returns the chart of error against bias for the chosen setting.
///
/// With increasing bias, the error of too dark pixels (acne) falls and that of too light pixels
/// (gap) rises. The marked amount minimises the sum of both. `None` if nothing was chosen, or if
/// the technique has no bias to optimise.
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
        let of_kind: Vec<&CurvePoint> = plan.curve.iter().filter(|p| p.kind == kind).collect();
        if of_kind.is_empty() {
            continue;
        }
        let kind = kind.name();
        let all = points(&of_kind, |estimate| estimate.error);
        let too_dark = points(&of_kind, |estimate| estimate.too_dark);
        let too_light = points(&of_kind, |estimate| estimate.too_light);
        figure.series.push(Series {
            style: Style::Line(2.5),
            ..Series::line(format!("{kind}: all"), color, all)
        });
        figure.series.push(Series {
            style: Style::Dashed(1.5),
            ..Series::line(format!("{kind}: acne (too dark)"), color, too_dark)
        });
        figure.series.push(Series {
            style: Style::Line(0.8),
            ..Series::line(format!("{kind}: gap (too light)"), color, too_light)
        });
    }
    let chosen: Vec<&CurvePoint> = plan.curve.iter().filter(|p| p.chosen).collect();
    let best = points(&chosen, |estimate| estimate.error);
    Some(figure.with(Series::points("chosen", "#c0392b", Marker::Star, best)))
}

/// Returns points of the curve: x is the bias, y is one part of the error.
fn points(curve: &[&CurvePoint], error: fn(&Estimate) -> f64) -> Vec<Point> {
    curve
        .iter()
        .map(|point| Point::at_position(f64::from(point.texels), error(&point.estimate)))
        .collect()
}
