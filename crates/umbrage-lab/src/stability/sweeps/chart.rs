//! A sweep as a static chart.

use super::Sweep;
use kuva::prelude::{Layout, LegendPosition, LinePlot, Plot, ReferenceLine, SvgBackend, render_multiple};

/// Colours that all kinds of colour vision tell apart (Okabe, Ito 2008, "Color Universal Design").
const COLORS: [&str; 7] = ["#0072b2", "#e69f00", "#009e73", "#d55e00", "#cc79a7", "#56b4e9", "#555555"];

/// Nothing at all has no place on a logarithmic axis: it is drawn at the least y that is drawn, a hundredth of the limit
/// or a thousandth.
fn floor(sweep: &Sweep) -> f64 {
    sweep.limit.map_or(1e-3, |limit| 0.01 * limit)
}

pub(super) fn svg(sweep: &Sweep) -> String {
    let floor = floor(sweep);
    let lines = sweep.curves.iter().zip(COLORS.iter().cycle()).map(|(curve, color)| {
        let points = curve.points.iter().map(|[x, y]| (*x, y.max(floor)));
        let line = LinePlot::new().with_data(points).with_color(*color).with_stroke_width(2.0);
        Plot::Line(line.with_legend(curve.label.clone()))
    });
    let plots: Vec<Plot> = lines.collect();
    let mut layout = Layout::auto_from_plots(&plots)
        .with_title(sweep.title.clone())
        .with_x_label(sweep.x.clone())
        .with_y_label(sweep.y.clone())
        .with_log_x()
        .with_log_y()
        .with_legend_position(LegendPosition::OutsideRightTop)
        .with_width(900.0)
        .with_height(420.0);
    if let Some(best) = sweep.best {
        layout =
            layout.with_reference_line(ReferenceLine::vertical(best).with_label(format!("best: {}", two_digits(best))));
    }
    if let Some(limit) = sweep.limit {
        layout = layout.with_reference_line(ReferenceLine::horizontal(limit).with_label("limit"));
    }
    SvgBackend::new().render_scene(&render_multiple(plots, layout))
}

/// Two digits that count.
fn two_digits(v: f64) -> String {
    let decimals = (1.0 - v.abs().max(f64::MIN_POSITIVE).log10().floor()).clamp(0.0, 12.0) as usize;
    format!("{v:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::two_digits;

    #[test]
    fn two_digits_count() {
        assert_eq!([0.000_731, 0.376, 1.25, 48.2].map(two_digits), ["0.00073", "0.38", "1.2", "48"]);
    }
}
