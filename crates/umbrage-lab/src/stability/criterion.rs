//! Criteria of a case: its own measure, and the measure that a fix may worsen.

use super::{
    case_truth::CaseTruth,
    cell::CriterionResult,
    measure::Measure,
    verdict::{Verdict, VerdictLimits},
};

/// A measure with its limits on one case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Criterion {
    /// The measure.
    pub measure: Measure,
    /// Limits to pass and to fail.
    pub limits: VerdictLimits,
}

impl Criterion {
    /// Returns a case's criteria: `measure`, and its opposite ([`Measure::opposite`]) if the case
    /// can fail it. `limits` returns a measure's limits.
    pub fn of_case(
        measure: Measure,
        case_truth: &CaseTruth,
        limits: impl Fn(Measure) -> VerdictLimits,
    ) -> Vec<Self> {
        let with_limits = |measure: Measure| Self {
            measure,
            limits: limits(measure),
        };
        let mut out = vec![with_limits(measure)];
        let opposite = measure.opposite().map(with_limits);
        // In an image that is dark all over, nothing can be acne.
        out.extend(opposite.filter(|criterion| criterion.can_fail(case_truth)));
        out
    }

    /// Reports whether a fully lit or a fully dark mask fails.
    pub fn can_fail(&self, case_truth: &CaseTruth) -> bool {
        [0.0, 1.0].into_iter().any(|visibility: f32| {
            let mask = vec![visibility; case_truth.ideal.len()];
            let figure = self.measure.figure(case_truth, &mask);
            self.limits.judge(figure) == Verdict::Fails
        })
    }

    /// Returns the criterion as data.
    pub(super) fn result(&self, case_truth: &CaseTruth) -> CriterionResult {
        CriterionResult {
            measure: self.measure.name().to_owned(),
            unit: self.measure.unit().to_owned(),
            limits: self.limits,
            reason: self.measure.reason().to_owned(),
            ideal: self.measure.figure(case_truth, &case_truth.ideal),
        }
    }
}
