//! Times two programs in turn.

use serde::Serialize;
use std::time::Duration;
use umbrage_plan::statistics::Sorted;

/// How often each of the two runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Repetitions {
    /// Runs that are not counted, before all others.
    pub warm_up: usize,
    /// Runs that count.
    pub runs: usize,
}

/// What was measured of both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Paired {
    /// Our times.
    pub ours: PairTimes,
    /// Their times.
    pub theirs: PairTimes,
    /// Median over the pairs of theirs / ours.
    pub ratio: f64,
}

/// What was measured of one of the two.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PairTimes {
    /// Shortest run, milliseconds.
    #[serde(rename = "least")]
    pub min: f64,
    /// Median run, milliseconds.
    pub median: f64,
    /// 90th percentile, milliseconds.
    pub high: f64,
}

/// A comparison: how often `ours` fits into `theirs`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Pair {
    /// What was done.
    pub work: String,
    /// Who did it, first ours.
    pub who: [String; 2],
    /// Our times.
    pub ours: PairTimes,
    /// Their times.
    pub theirs: PairTimes,
    /// Median over the pairs of theirs / ours: above 1, ours is the faster.
    pub ratio: f64,
    /// The ratio that is asked for, if any.
    pub bar: Option<f64>,
    /// Pairs counted.
    pub runs: usize,
    /// Fault of our answers. `None` if they are right.
    pub fault: Option<String>,
}

impl Pair {
    /// Whether the bar is met, if there is one, and our answers are right.
    pub fn met(&self) -> bool {
        self.bar.is_none_or(|bar| self.ratio >= bar) && self.fault.is_none()
    }
}

/// Runs both in turn. Each returns how long its run took.
///
/// # Errors
/// Errors if either of them does; returns the first error.
pub fn paired<E>(
    repetitions: Repetitions,
    mut ours: impl FnMut() -> Result<Duration, E>,
    mut theirs: impl FnMut() -> Result<Duration, E>,
) -> Result<Paired, E> {
    let mut our_times = Vec::with_capacity(repetitions.runs);
    let mut their_times = Vec::with_capacity(repetitions.runs);
    let mut ratios = Vec::with_capacity(repetitions.runs);
    for run in 0..repetitions.warm_up + repetitions.runs {
        // Who goes first alternates, so that neither always follows the other's heat.
        let our_time;
        let their_time;
        if run % 2 == 0 {
            our_time = milliseconds(ours()?);
            their_time = milliseconds(theirs()?);
        } else {
            their_time = milliseconds(theirs()?);
            our_time = milliseconds(ours()?);
        }
        if run >= repetitions.warm_up {
            our_times.push(our_time);
            their_times.push(their_time);
            // No division by zero where the clock didn't move.
            ratios.push(their_time / our_time.max(1e-6));
        }
    }
    Ok(Paired {
        ours: PairTimes::of(our_times),
        theirs: PairTimes::of(their_times),
        ratio: PairTimes::of(ratios).median,
    })
}

fn milliseconds(d: Duration) -> f64 {
    d.as_secs_f64() * 1e3
}

impl PairTimes {
    /// Returns the figures of some values; NaN without any.
    fn of(values: Vec<f64>) -> Self {
        let sorted = Sorted::new(values);
        Self {
            min: sorted.nearest(0.0).unwrap_or(f64::NAN),
            median: sorted.nearest(0.5).unwrap_or(f64::NAN),
            high: sorted.nearest(0.9).unwrap_or(f64::NAN),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_are_of_neighbours() {
        // Both get slower and slower; their ratio doesn't.
        let drifting = |base: u64| {
            let mut run = 0;
            move || {
                run += 1;
                Ok::<_, ()>(Duration::from_millis(base * run))
            }
        };
        let repetitions = Repetitions {
            warm_up: 0,
            runs: 5,
        };
        let found = paired(repetitions, drifting(2), drifting(6)).expect("no errors");
        assert!((found.ratio - 3.0).abs() < 1e-9, "{found:?}");
        assert_eq!(
            (found.ours.min, found.ours.median, found.theirs.median),
            (2.0, 6.0, 18.0)
        );
    }
}
