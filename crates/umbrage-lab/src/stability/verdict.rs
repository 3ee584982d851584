//! Verdicts (pass, degraded, fails), the limits between them, and judgements by them.

use serde::{Deserialize, Serialize};

/// A figure judged against its limits. The order is from the best to the worst; the greatest
/// verdict of a cell counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The figure is at most the first limit.
    Pass,
    /// The figure does not depend on the technique's errors, so it is not a pass.
    NotMeasured,
    /// The figure is between the two limits.
    Degraded,
    /// The figure is above the second limit.
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

/// Ratio of the failing limit to the passing one. On a map with a quarter of the side, edges, gaps
/// and displacements are four times as wide.
pub const FAILS_AT: f64 = 4.0;

/// Limits of a figure to pass and to fail, in the measure's unit. Smaller figures are better.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct VerdictLimits {
    /// Greatest passing figure.
    pub pass: f64,
    /// Figure above which a case fails.
    pub fails: f64,
}

impl VerdictLimits {
    /// Returns these limits.
    pub const fn new(pass: f64, fails: f64) -> Self {
        Self { pass, fails }
    }

    /// Returns limits for errors that edge aliasing alone causes on any map.
    ///
    /// A figure passes up to twice that of a perfect map of the same size, `ideal` (see
    /// [`CaseTruth::ideal`](super::CaseTruth)), plus the smallest visible step. So a kernel may
    /// blur edges by a few texels. More than [`FAILS_AT`] times that fails.
    pub fn over_ideal(ideal: f64, visible: f64) -> Self {
        let pass = 2.0 * ideal + visible;
        Self {
            pass,
            fails: FAILS_AT * pass,
        }
    }

    /// Returns limits with both multiplied.
    pub fn times(self, factor: f64) -> Self {
        Self {
            pass: self.pass * factor,
            fails: self.fails * factor,
        }
    }

    /// Returns limits with both raised by a figure that no map can avoid.
    pub fn raised_by(self, unavoidable: f64) -> Self {
        Self {
            pass: self.pass + unavoidable,
            fails: self.fails + unavoidable,
        }
    }

    /// Returns limits capped by the figure of no shadow at all, `none`: a pass has at most half of
    /// it, and more than three quarters of it fail, however coarse the map.
    pub fn capped_by_no_shadow(self, none: f64) -> Self {
        if none > 0.0 {
            Self {
                pass: self.pass.min(0.5 * none),
                fails: self.fails.min(0.75 * none),
            }
        } else {
            self
        }
    }

    /// Judges a figure, and returns it with the verdict.
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
    /// Figure in the measure's unit; smaller is better. `None` if it is not measured.
    pub figure: Option<f64>,
    /// Verdict by the limits.
    pub verdict: Verdict,
    /// Reason why it is not measured; `None` if it is.
    pub reason: Option<String>,
}

impl Judgement {
    /// Returns the judgement of a figure that could not have failed, with the reason.
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
        assert_eq!(
            limits.capped_by_no_shadow(2.0),
            VerdictLimits::new(1.0, 1.5)
        );
        assert_eq!(
            [
                limits.capped_by_no_shadow(100.0),
                limits.capped_by_no_shadow(0.0)
            ],
            [limits; 2]
        );
        assert_eq!(limits.times(0.5), VerdictLimits::new(1.0, 4.0));
        assert_eq!(limits.raised_by(0.5), VerdictLimits::new(2.5, 8.5));
    }
}
