//! Times with simulated noise, in so many cases that rare errors would be detected.

use super::*;
use crate::compare::RowOutcome;

/// Noise with a seed: xorshift (Marsaglia 2003).
struct Noise(u64);

impl Noise {
    /// Returns a number from 0 to 1.
    fn uniform(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn chance(&mut self, of: f64) -> bool {
        self.uniform() < of
    }

    /// Returns an approximately normal number: twelve uniform numbers have a variance of 1.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }

    /// Returns ratios of a row that takes `factor` yardsticks, on 2 cores shared with other
    /// programs.
    ///
    /// Measured there in 30 rows of 60 runs: the usual scatter is 1/14, and one run in 25 scatters
    /// more. In one row of four the scatter is a third, and now and then a run or its yardstick is
    /// delayed by several times its duration.
    fn ratios(&mut self, factor: f64, runs: usize) -> Vec<f64> {
        let rough = self.chance(0.25);
        let (scatter, held_up) = if rough { (0.3, 0.15) } else { (0.07, 0.04) };
        let run = |noise: &mut Self| {
            let row = if noise.chance(held_up) {
                1.0 + 5.0 * noise.uniform()
            } else {
                1.0
            };
            let yardstick = if noise.chance(held_up) {
                1.0 + 2.0 * noise.uniform()
            } else {
                1.0
            };
            factor * (scatter * noise.normal()).exp() * row / yardstick
        };
        (0..runs).map(|_| run(self)).collect()
    }

    fn sample(&mut self, factor: f64, runs: usize) -> RatioSample {
        sample(self.ratios(factor, runs), factor)
    }
}

/// Returns a sample with these ratios and this fastest run, milliseconds.
fn sample(ratios: Vec<f64>, least_ms: f64) -> RatioSample {
    RatioSample {
        ratio: Ranks::from_figures(ratios).expect("some"),
        least_ms,
        yardstick: 1.0,
        device_units: None,
    }
}

fn row(technique: &str, slug: usize) -> CompareRow {
    CompareRow {
        same_as: None,
        technique: technique.to_owned(),
        settings: slug.to_string(),
        slug: slug.to_string(),
        backend: "cpu".to_owned(),
        outcome: RowOutcome::Unsupported {
            reason: String::new(),
        },
    }
}

/// Returns the numbers of rows and techniques that count as slower if row `i` takes `now(i)` times
/// as long as before.
fn alarms(noise: &mut Noise, rows: usize, runs: usize, now: impl Fn(usize) -> f64) -> [usize; 2] {
    let all: Vec<CompareRow> = (0..rows)
        .map(|i| row(["pcf", "hard", "pcss", "volumes"][i % 4], i))
        .collect();
    let then: Vec<RatioSample> = (0..rows).map(|_| noise.sample(0.7, runs)).collect();
    let after: Vec<RatioSample> = (0..rows)
        .map(|i| noise.sample(0.7 * now(i), runs))
        .collect();
    let timing = |i: usize| Timing {
        scene: (0, "made up"),
        row: &all[i],
        then: then[i],
        now: after[i],
    };
    let timings: Vec<_> = (0..rows).map(timing).collect();
    let mut out = [0, 0];
    for suspect in judge(&timings).suspects {
        let place = |requested: &RowToRetime| {
            requested
                .stem
                .trim_end_matches(".cpu")
                .parse::<usize>()
                .expect("a number")
        };
        // Let ratios decide alone, without the fastest runs.
        let known = |fresh: &[Vec<f64>]| {
            fresh
                .iter()
                .map(|f| Some(sample(f.clone(), f64::INFINITY)))
                .collect::<Vec<_>>()
        };
        let mut fresh: Vec<Vec<f64>> = vec![Vec::new(); suspect.rows.len()];
        let mut open = true;
        for _ in 0..super::super::ROUNDS {
            for (fresh, requested) in fresh.iter_mut().zip(&suspect.rows) {
                fresh.extend(noise.ratios(0.7 * now(place(requested)), 15));
            }
            open = open && !suspect.is_cleared(&known(&fresh));
        }
        if open && suspect.verdict(&known(&fresh)).is_some() {
            out[usize::from(suspect.whole)] += 1;
        }
    }
    out
}

#[test]
fn two_hundred_comparisons_of_unchanged_code_raise_no_alarm() {
    let mut noise = Noise(0x9e37_79b9_7f4a_7c15);
    for runs in [5, 9, 15] {
        for _ in 0..70 {
            assert_eq!(
                alarms(&mut noise, 1000, runs, |_| 1.0),
                [0, 0],
                "{runs} runs"
            );
        }
    }
}

/// Rough noise hides some of them.
#[test]
fn a_row_that_takes_twice_as_long_is_caught() {
    let mut noise = Noise(0x1234_5678_9abc_def1);
    let slow = |i: usize| if i == 17 { 2.0 } else { 1.0 };
    let caught: usize = (0..100).map(|_| alarms(&mut noise, 40, 9, slow)[0]).sum();
    assert!(caught >= 60, "{caught} of 100");
    let quiet = vec![1.0, 1.02, 0.98, 1.05, 1.0, 0.97, 1.1, 1.0, 1.03];
    let slower = sample(quiet.iter().map(|r| 2.0 * r).collect(), 6.0);
    let quiet = sample(quiet, 3.0);
    let rows = [row("pcf", 0)];
    let timing = Timing {
        scene: (3, "made up"),
        row: &rows[0],
        then: quiet,
        now: slower,
    };
    let judged = judge(&[timing]);
    assert_eq!(judged.suspects.len(), 1);
    let said = judged.suspects[0].verdict(&[Some(slower)]).expect("slower");
    assert!(
        said.starts_with("made up: pcf (0) on cpu: slower by a factor of 2.00"),
        "{said}"
    );
    assert_eq!(
        judged.suspects[0].verdict(&[Some(quiet)]),
        None,
        "as before when timed again"
    );
    assert_eq!(
        judged.suspects[0].verdict(&[None]),
        None,
        "no longer measured"
    );
    // The baseline's yardstick was delayed next to all runs, as this run or later ones show.
    let quicker = RatioSample {
        yardstick: 0.7,
        ..slower
    };
    let found = judge(&[Timing {
        now: quicker,
        ..timing
    }]);
    assert!(found.suspects.is_empty() && found.rough == 1, "{found:?}");
    assert_eq!(judged.suspects[0].verdict(&[Some(quicker)]), None);
    assert!(judged.suspects[0].is_cleared(&[Some(quicker)]));
    // A device had a quarter of its clock in the baseline, and is at full clock now.
    let then = RatioSample {
        device_units: Some(8.0),
        ..quiet
    };
    let now = RatioSample {
        least_ms: slower.least_ms / 4.0,
        yardstick: 0.25,
        device_units: Some(8.0),
        ..slower
    };
    let found = judge(&[Timing {
        then,
        now,
        ..timing
    }]);
    assert!(found.suspects.len() == 1 && found.rough == 0, "{found:?}");
    assert!(!found.suspects[0].is_cleared(&[Some(now)]));
    assert!(found.suspects[0].verdict(&[Some(now)]).is_some());
    // There are too few undisturbed new runs, or none.
    for runs in [0, MANY - 1] {
        let few = RatioSample {
            ratio: Ranks {
                runs,
                ..slower.ratio
            },
            ..slower
        };
        assert!(
            judged.suspects[0].lacks_calm_runs(&[Some(few)])
                && !judged.suspects[0].is_cleared(&[Some(few)])
        );
        assert_eq!(judged.suspects[0].verdict(&[Some(few)]), None);
    }
    let held_up = RatioSample {
        least_ms: 3.9,
        ..slower
    };
    assert_eq!(
        judged.suspects[0].verdict(&[Some(held_up)]),
        None,
        "a run nearly as quick as ever"
    );
}

#[test]
fn few_runs_are_not_judged() {
    let rows = [row("pcf", 0)];
    let [then, now] = [1.0, 9.0].map(|r| sample(vec![r; MIN_RUNS as usize - 1], r));
    let judged = judge(&[Timing {
        scene: (0, ""),
        row: &rows[0],
        then,
        now,
    }]);
    assert!(
        judged.suspects.is_empty() && judged.rough == 1,
        "{judged:?}"
    );
}

/// Each row alone is too noisy.
#[test]
fn a_technique_that_gets_slower_by_half_is_caught() {
    let mut noise = Noise(0x0dd_ba11);
    for _ in 0..20 {
        let [_, techniques] = alarms(&mut noise, 200, 5, |i| if i % 4 == 2 { 1.5 } else { 1.0 });
        assert_eq!(techniques, 1);
    }
    let rows: Vec<CompareRow> = (0..MIN_ROWS).map(|i| row("pcss", i)).collect();
    let timing = |(row, scene): (_, usize)| {
        let [then, now] = [1.0, 0.5].map(|r| sample(vec![r + 0.01 * scene as f64; 9], r));
        Timing {
            scene: (scene, ""),
            row,
            then,
            now,
        }
    };
    let timings: Vec<_> = rows.iter().zip(0..).map(timing).collect();
    let quicker = judge(&timings).quicker;
    assert!(
        quicker.len() == 1 && quicker[0].starts_with("pcss on cpu: quicker by a factor of 1.9"),
        "{quicker:?}"
    );
}
