//! Figures that are the same on every run: any growth is a change.

use super::ROUNDING;
use crate::compare::Measured;
use umbrage_core::metrics::MAX_UNDECIDED_SHARE;
use umbrage_plan::cost::CostModel;

/// A figure that should not grow.
pub(super) struct BaselineFigure {
    name: &'static str,
    then: f64,
    now: f64,
    noise: f64,
}

impl BaselineFigure {
    /// Whether it grew, and what to say, if it changed beyond the noise.
    pub(super) fn change(&self) -> Option<(bool, String)> {
        let difference = self.now - self.then;
        let noise = self.noise + ROUNDING * self.then.abs().max(self.now.abs());
        let what = || format!("{} {} -> {}", self.name, short(self.then), short(self.now));
        (difference.abs() > noise).then(|| (difference > 0.0, what()))
    }
}

/// The figures of a row, then and now. Where no pixel counts there are no errors, then as now: else other pixels count, and
/// the scene isn't compared.
pub(super) fn of(
    backend: &str,
    then: &Measured,
    now: &Measured,
    exact: bool,
) -> Vec<BaselineFigure> {
    let prices = CostModel::of(backend);
    let [cost_then, cost_now] = [then, now].map(|m| prices.milliseconds(&m.work));
    let figure = |name, then, now, noise| BaselineFigure {
        name,
        then,
        now,
        noise,
    };
    let mut out = Vec::new();
    if let (Some(a), Some(b)) = (&then.errors, &now.errors) {
        // Undecided pixels may all flip: in a share of the image, that share; in a mean square, that much.
        let share = if exact {
            0.0
        } else {
            100.0 * MAX_UNDECIDED_SHARE
        };
        let rmse = if exact {
            0.0
        } else {
            (a.rmse.powi(2) + MAX_UNDECIDED_SHARE).sqrt() - a.rmse
        };
        out.extend([
            figure("RMSE", a.rmse, b.rmse, rmse),
            figure("false shadow %", a.false_shadow, b.false_shadow, share),
            figure("false light %", a.false_light, b.false_light, share),
            figure("acne %", a.acne, b.acne, share),
        ]);
    }
    out.push(figure("cost ms", cost_then, cost_now, 0.0));
    out.push(figure("bytes", then.bytes as f64, now.bytes as f64, 0.0));
    out
}

/// Four digits that count.
pub(super) fn short(v: f64) -> String {
    if v == 0.0 || (0.01..1e6).contains(&v.abs()) {
        format!("{:.4}", v)
    } else {
        format!("{v:.3e}")
    }
}
