//! Times two programs in turn.

use serde::Serialize;
use std::time::Duration;
use umbrage_plan::statistics::Sorted;

/// Number of runs of each program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Repetitions {
    /// Uncounted runs before all others.
    pub warm_up: usize,
    /// Counted runs.
    pub runs: usize,
}

/// Times of both programs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Paired {
    /// Our times.
    pub ours: PairTimes,
    /// Their times.
    pub theirs: PairTimes,
    /// Median over the pairs of theirs / ours.
    pub ratio: f64,
}

/// Times of one program.
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

/// A comparison of two programs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Pair {
    /// Description of the work.
    pub work: String,
    /// The programs, first ours.
    pub who: [String; 2],
    /// Our times.
    pub ours: PairTimes,
    /// Their times.
    pub theirs: PairTimes,
    /// Median over the pairs of theirs / ours. Above 1, ours is faster.
    pub ratio: f64,
    /// Target of the ratio, if any.
    pub bar: Option<f64>,
    /// Number of counted pairs.
    pub runs: usize,
    /// Error of our results. `None` if they are correct.
    pub fault: Option<String>,
}

impl Pair {
    /// Reports whether the target is met, if any, and our results are correct.
    pub fn is_met(&self) -> bool {
        self.bar.is_none_or(|bar| self.ratio >= bar) && self.fault.is_none()
    }
}

/// Runs both in turn. Each returns the duration of its run.
///
/// # Errors
/// Returns the first error of either program.
pub fn measure_pairs<E>(
    repetitions: Repetitions,
    mut ours: impl FnMut() -> Result<Duration, E>,
    mut theirs: impl FnMut() -> Result<Duration, E>,
) -> Result<Paired, E> {
    let mut our_times = Vec::with_capacity(repetitions.runs);
    let mut their_times = Vec::with_capacity(repetitions.runs);
    let mut ratios = Vec::with_capacity(repetitions.runs);
    for run in 0..repetitions.warm_up + repetitions.runs {
        // Alternate the order, so that neither program always runs on the hotter machine.
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
            // Avoid a division by zero if the clock didn't advance.
            ratios.push(their_time / our_time.max(1e-6));
        }
    }
    Ok(Paired {
        ours: PairTimes::from_values(our_times),
        theirs: PairTimes::from_values(their_times),
        ratio: PairTimes::from_values(ratios).median,
    })
}

fn milliseconds(d: Duration) -> f64 {
    d.as_secs_f64() * 1e3
}

impl PairTimes {
    /// Returns the statistics of some values. NaN without values.
    fn from_values(values: Vec<f64>) -> Self {
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
        // Both slow down, but their ratio doesn't change.
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
        let found = measure_pairs(repetitions, drifting(2), drifting(6)).expect("no errors");
        assert!((found.ratio - 3.0).abs() < 1e-9, "{found:?}");
        assert_eq!(
            (found.ours.min, found.ours.median, found.theirs.median),
            (2.0, 6.0, 18.0)
        );
    }
}
