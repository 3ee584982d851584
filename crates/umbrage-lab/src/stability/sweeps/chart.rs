//! Draws a sweep as a chart.

use super::curve::Sweep;
use crate::output::figure::{COLORS, Figure, Point, Reference, Series, Style};

/// Returns the least y of the chart: a hundredth of the limit, or a thousandth without one. Smaller
/// values are drawn there, as a logarithmic axis has no 0.
fn floor(sweep: &Sweep) -> f64 {
    sweep.limit.map_or(1e-3, |limit| 0.01 * limit)
}

impl Sweep {
    /// Returns the chart as a self-contained SVG.
    pub fn svg(&self) -> String {
        figure(self).svg()
    }
}

fn figure(sweep: &Sweep) -> Figure {
    let floor = floor(sweep);
    let mut figure = Figure::new(&sweep.title, &sweep.x, &sweep.y).log(true, true);
    figure.size = [900.0, 420.0];
    for (i, curve) in sweep.curves.iter().enumerate() {
        let points = curve
            .points
            .iter()
            .map(|[x, y]| Point::at_position(*x, y.max(floor)))
            .collect();
        let line = Series::line(&curve.label, COLORS[i % COLORS.len()], points);
        // Dash the lines whose colors repeat.
        let style = if i < COLORS.len() {
            line.style
        } else {
            Style::Dashed(2.0)
        };
        figure.series.push(Series { style, ..line });
    }
    if let Some(x) = sweep.best {
        let label = format!("best: {}", two_digits(x));
        figure.references.push(Reference::Across(x, label));
    }
    if let Some(y) = sweep.limit {
        figure.references.push(Reference::Up(y, "limit".to_owned()));
    }
    figure
}

/// Formats a number with two significant digits.
fn two_digits(v: f64) -> String {
    // Decimals of the second significant digit; 0 for 10 and more.
    let exponent = v.abs().max(f64::MIN_POSITIVE).log10().floor();
    let decimals = (1.0 - exponent).clamp(0.0, 12.0) as usize;
    format!("{v:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stability::sweeps::curve::Curve;
    use std::collections::HashSet;

    #[test]
    fn two_digits_count() {
        assert_eq!(
            [0.000_731, 0.376, 1.25, 48.2].map(two_digits),
            ["0.00073", "0.38", "1.2", "48"]
        );
    }

    #[test]
    fn what_is_nothing_lies_at_the_bottom_and_curves_look_unlike() {
        let mut curves = Vec::new();
        for i in 0..10 {
            curves.push(Curve {
                label: i.to_string(),
                points: vec![[1.0, 0.0], [2.0, 5.0]],
            });
        }
        let sweep = Sweep {
            name: "n".to_owned(),
            title: "t".to_owned(),
            x: "x".to_owned(),
            y: "y".to_owned(),
            curves,
            best: Some(2.0),
            limit: Some(1.0),
            disagreeing: None,
        };
        let figure = figure(&sweep);
        assert_eq!(
            figure.series[0].points,
            [Point::at_position(1.0, 0.01), Point::at_position(2.0, 5.0)]
        );
        let looks: HashSet<String> = figure
            .series
            .iter()
            .map(|s| format!("{} {:?}", s.color, s.style))
            .collect();
        assert_eq!(looks.len(), 10);
        assert_eq!(figure.references.len(), 2);
        assert_eq!(figure.log, [true; 2]);
    }
}
