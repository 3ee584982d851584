//! Two things timed in turn.

use serde::Serialize;
use std::time::Duration;
use umbrage_plan::statistics::Sorted;

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
}

impl Pair {
    /// Whether the bar is met; always when there is none.
    pub fn met(&self) -> bool {
        self.bar.is_none_or(|bar| self.ratio >= bar)
    }
}

/// Runs both in turn, `warm_up` times uncounted, then `runs` times. Each tells how long its run took.
///
/// # Errors
/// The first error of either.
pub fn paired<E>(
    [warm_up, runs]: [usize; 2],
    mut ours: impl FnMut() -> Result<Duration, E>,
    mut theirs: impl FnMut() -> Result<Duration, E>,
) -> Result<(PairTimes, PairTimes, f64), E> {
    let mut times = Vec::with_capacity(runs);
    for run in 0..warm_up + runs {
        // Who goes first alternates, so that neither always follows the other's heat.
        let pair = if run % 2 == 0 {
            let a = ours()?;
            (a, theirs()?)
        } else {
            let b = theirs()?;
            (ours()?, b)
        };
        if run >= warm_up {
            times.push((milliseconds(pair.0), milliseconds(pair.1)));
        }
    }
    let ratio = PairTimes::of(times.iter().map(|(a, b)| b / a.max(1e-6))).median;
    Ok((
        PairTimes::of(times.iter().map(|t| t.0)),
        PairTimes::of(times.iter().map(|t| t.1)),
        ratio,
    ))
}

fn milliseconds(d: Duration) -> f64 {
    d.as_secs_f64() * 1e3
}

impl PairTimes {
    /// Of at least one value.
    fn of(values: impl Iterator<Item = f64>) -> Self {
        let sorted = Sorted::new(values.collect());
        let at = |share: f64| sorted.nearest(share).unwrap_or(f64::NAN);
        Self {
            min: at(0.0),
            median: at(0.5),
            high: at(0.9),
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
        let (a, b, ratio) = paired([0, 5], drifting(2), drifting(6)).expect("no errors");
        assert!((ratio - 3.0).abs() < 1e-9, "{ratio}");
        assert_eq!((a.min, a.median, b.median), (2.0, 6.0, 18.0));
    }
}
