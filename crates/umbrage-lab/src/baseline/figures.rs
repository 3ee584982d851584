//! Figures that are equal on every run: errors, predicted cost and bytes. Any growth is a change.

use super::changes::ROUNDING;
use crate::compare::Measured;
use umbrage_core::metrics::MAX_UNDECIDED_SHARE;
use umbrage_plan::cost::CostModel;

/// A figure that must not grow.
pub(super) struct BaselineFigure {
    name: &'static str,
    then: f64,
    now: f64,
    /// Maximum difference that counts as no change.
    noise: f64,
}

impl BaselineFigure {
    /// Returns the change. `None` within the noise.
    pub(super) fn change(&self) -> Option<Change> {
        let difference = self.now - self.then;
        let noise = self.noise + ROUNDING * self.then.abs().max(self.now.abs());
        if difference.abs() > noise {
            let what = format!("{} {} -> {}", self.name, short(self.then), short(self.now));
            Some(if difference > 0.0 {
                Change::Grew(what)
            } else {
                Change::Shrank(what)
            })
        } else {
            None
        }
    }
}

/// A change of a figure, with a text that states the name and both values.
pub(super) enum Change {
    /// For the worse.
    Grew(String),
    /// For the better.
    Shrank(String),
}

/// Returns the figures of a row, then and now. `exact` is whether rounding is the same.
///
/// If no pixel counts, there are no errors, neither then nor now. Otherwise other pixels would
/// count, and the scene would not be compared.
pub(super) fn figures_of_row(
    backend: &str,
    then: &Measured,
    now: &Measured,
    exact: bool,
) -> Vec<BaselineFigure> {
    let prices = CostModel::for_backend(backend);
    let cost_then = prices.milliseconds(&then.work);
    let cost_now = prices.milliseconds(&now.work);
    let mut out = Vec::new();
    if let (Some(a), Some(b)) = (&then.errors, &now.errors) {
        // All undecided pixels may flip. This changes a percentage of the image by at most their
        // percentage, and a mean square by at most their share.
        let mut percent_noise = 0.0;
        let mut rmse_noise = 0.0;
        if !exact {
            percent_noise = 100.0 * MAX_UNDECIDED_SHARE;
            rmse_noise = (a.rmse.powi(2) + MAX_UNDECIDED_SHARE).sqrt() - a.rmse;
        }
        out.push(figure("RMSE", a.rmse, b.rmse, rmse_noise));
        out.push(figure(
            "false shadow %",
            a.false_shadow,
            b.false_shadow,
            percent_noise,
        ));
        out.push(figure(
            "false light %",
            a.false_light,
            b.false_light,
            percent_noise,
        ));
        out.push(figure("acne %", a.acne, b.acne, percent_noise));
    }
    out.push(figure("cost ms", cost_then, cost_now, 0.0));
    out.push(figure("bytes", then.bytes as f64, now.bytes as f64, 0.0));
    out
}

fn figure(name: &'static str, then: f64, now: f64, noise: f64) -> BaselineFigure {
    BaselineFigure {
        name,
        then,
        now,
        noise,
    }
}

/// Formats a number with four decimals, or in scientific notation if it is very large or small.
pub(super) fn short(v: f64) -> String {
    if v == 0.0 || (0.01..1e6).contains(&v.abs()) {
        format!("{:.4}", v)
    } else {
        format!("{v:.3e}")
    }
}
