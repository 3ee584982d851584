//! Pass, degraded or fails.

use serde::{Deserialize, Serialize};

/// What a figure means against its limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// At most the first limit.
    Pass,
    /// Between the two.
    Degraded,
    /// Above the second.
    Fails,
}

impl Verdict {
    /// A sign that reads without colour.
    pub fn sign(self) -> char {
        match self {
            Self::Pass => '✓',
            Self::Degraded => '~',
            Self::Fails => '✗',
        }
    }

    /// One word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Degraded => "degraded",
            Self::Fails => "fails",
        }
    }
}

/// How much worse than a pass may be before it is a failure: as much as a map of a quarter of the side, on which edges,
/// gaps and displacements are four times as wide.
pub const FAILS_AT: f64 = 4.0;

/// Where a figure stops to pass and where it begins to fail, in the measure's unit. Smaller is better everywhere.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct VerdictLimits {
    /// At most this passes.
    pub pass: f64,
    /// More than this fails.
    pub fails: f64,
}

impl VerdictLimits {
    /// Given limits.
    pub const fn new(pass: f64, fails: f64) -> Self {
        Self { pass, fails }
    }

    /// For what edge aliasing alone must cause on a map: passes up to twice what a perfect map of the same size shows
    /// (see [`CaseTruth::ideal`](super::CaseTruth)), so that a kernel may blur edges by a few texels, plus the smallest step
    /// that is visible; fails above [`FAILS_AT`] times that.
    pub fn over_ideal(ideal: f64, visible: f64) -> Self {
        let pass = 2.0 * ideal + visible;
        Self {
            pass,
            fails: FAILS_AT * pass,
        }
    }

    /// No looser than what no shadow at all shows, `none`: a pass has at most half of that, and more than three quarters
    /// fail, however coarse the map.
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

    /// The verdict. Figures that are not finite fail.
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
    }
}
