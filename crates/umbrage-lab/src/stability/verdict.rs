//! Verdicts (pass, degraded, fails), the limits between them, and judgements by them.

use serde::{Deserialize, Serialize};

/// A figure judged against its limits. The order is from the best to the worst: of a cell's
/// verdicts the greatest counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// At most the first limit.
    Pass,
    /// The figure could not have been any other, whatever the technique does wrong: no pass.
    NotMeasured,
    /// Between the two.
    Degraded,
    /// Above the second.
    Fails,
}

impl Verdict {
    /// Returns a sign that reads without color.
    pub fn sign(self) -> char {
        match self {
            Self::Pass => '✓',
            Self::NotMeasured => '·',
            Self::Degraded => '~',
            Self::Fails => '✗',
        }
    }

    /// Returns the verdict as one word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::NotMeasured => "not measured",
            Self::Degraded => "degraded",
            Self::Fails => "fails",
        }
    }
}

/// The limit of failure over the limit of a pass. On a map with a quarter of the side, edges, gaps
/// and displacements are four times as wide.
pub const FAILS_AT: f64 = 4.0;

/// The figures up to which a case passes and above which it fails, in the measure's unit. Smaller
/// figures are better.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct VerdictLimits {
    /// At most this passes.
    pub pass: f64,
    /// More than this fails.
    pub fails: f64,
}

impl VerdictLimits {
    /// Returns these limits.
    pub const fn new(pass: f64, fails: f64) -> Self {
        Self { pass, fails }
    }

    /// Returns limits for errors that edge aliasing alone causes on any map. A pass has up to twice
    /// the figure of a perfect map of the same size, `ideal` (see
    /// [`CaseTruth::ideal`](super::CaseTruth)), so that a kernel may blur edges by a few texels,
    /// plus the smallest visible step; more than [`FAILS_AT`] times that fails.
    pub fn over_ideal(ideal: f64, visible: f64) -> Self {
        let pass = 2.0 * ideal + visible;
        Self {
            pass,
            fails: FAILS_AT * pass,
        }
    }

    /// Returns limits of which both are multiplied.
    pub fn times(self, factor: f64) -> Self {
        Self {
            pass: self.pass * factor,
            fails: self.fails * factor,
        }
    }

    /// Returns limits of which both are higher by a figure that no map can avoid.
    pub fn beyond(self, unavoidable: f64) -> Self {
        Self {
            pass: self.pass + unavoidable,
            fails: self.fails + unavoidable,
        }
    }

    /// Returns limits that are no looser than the figure of no shadow at all, `none`, allows: a
    /// pass has at most half of that, and more than three quarters of it fail, however coarse the
    /// map.
    pub fn below(self, none: f64) -> Self {
        if none > 0.0 {
            Self {
                pass: self.pass.min(0.5 * none),
                fails: self.fails.min(0.75 * none),
            }
        } else {
            self
        }
    }

    /// Judges a figure, and keeps it beside the verdict.
    pub fn judgement(&self, figure: f64) -> Judgement {
        Judgement {
            figure: Some(figure),
            verdict: self.judge(figure),
            reason: None,
        }
    }

    /// Judges a figure. Figures that are not finite fail.
    pub fn judge(&self, figure: f64) -> Verdict {
        if figure <= self.pass {
            Verdict::Pass
        } else if figure <= self.fails {
            Verdict::Degraded
        } else {
            Verdict::Fails
        }
    }
}

/// A cell's figure by one criterion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Judgement {
    /// In the measure's unit; smaller is better. None if it is not measured.
    pub figure: Option<f64>,
    /// Against the limits.
    pub verdict: Verdict,
    /// Why it is not measured; none if it is.
    pub reason: Option<String>,
}

impl Judgement {
    /// Returns the judgement of what could not have failed. `reason` says why.
    pub fn not_measured(reason: &str) -> Self {
        Self {
            figure: None,
            verdict: Verdict::NotMeasured,
            reason: Some(reason.to_owned()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_belong_to_the_better_side_and_nan_fails() {
        let limits = VerdictLimits::over_ideal(0.5, 1.0);
        assert_eq!(limits, VerdictLimits::new(2.0, 8.0));
        let judged = [0.0, 2.0, 2.1, 8.0, 8.1, f64::NAN, f64::INFINITY].map(|v| limits.judge(v));
        use Verdict::{Degraded as D, Fails as F, Pass as P};
        assert_eq!(judged, [P, P, D, D, F, F, F]);
        assert_eq!(limits.below(2.0), VerdictLimits::new(1.0, 1.5));
        assert_eq!([limits.below(100.0), limits.below(0.0)], [limits; 2]);
        assert_eq!(limits.times(0.5), VerdictLimits::new(1.0, 4.0));
        assert_eq!(limits.beyond(0.5), VerdictLimits::new(2.5, 8.5));
    }
}
