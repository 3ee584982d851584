//! Times at which points are lit.

use crate::{
    Disc, Facets, FacetsError, Points, Stated,
    disc::disc_seen,
    facets::check_positive,
    rays::{NO_BLOCKER, Rays},
    stated::AnswerHash,
    suns::frame_towards,
};
use glam::{DMat3, DVec3};

/// A span of time, and conventions for the sun.
#[derive(Clone, Debug, PartialEq)]
pub struct Day {
    /// First time, seconds.
    pub start_s: f64,
    /// Last time, seconds.
    pub end_s: f64,
    /// Greatest distance between samples, seconds. Shorter spans of light or shadow may be missed.
    pub step_s: f64,
    /// Error to which the times of changes are bisected, seconds.
    pub bisect_s: f64,
    /// Windows (start, end) in seconds outside which light doesn't count; empty for all of the day.
    pub windows: Vec<[f64; 2]>,
    /// A point is lit while it sees at least half of this disc; `None` for the disc's centre.
    pub half_of: Option<Disc>,
    /// True if the path includes refraction. Only [`Stated`] uses it.
    pub refraction: bool,
}

impl Default for Day {
    /// One day by steps of a minute, bisected to a second, the disc's centre, without refraction.
    fn default() -> Self {
        Self {
            start_s: 0.0,
            end_s: 86_400.0,
            step_s: 60.0,
            bisect_s: 1.0,
            windows: Vec::new(),
            half_of: None,
            refraction: false,
        }
    }
}

impl Day {
    fn check(&self) -> Result<(), FacetsError> {
        let length = self.end_s - self.start_s;
        check_positive("step, seconds", self.step_s)?;
        check_positive("bisection, seconds", self.bisect_s)?;
        check_positive("length of the day, seconds", length)?;
        // Each sample takes memory.
        check_positive("number of samples below 2e6", 2e6 - length / self.step_s)?;
        let mut end = f64::NEG_INFINITY;
        for window in &self.windows {
            if !(window[0] >= end && window[1] > window[0]) {
                let help = "use rising windows that don't overlap";
                return Err(FacetsError::new(
                    "windows",
                    format!("have {window:?}"),
                    help,
                ));
            }
            end = window[1];
        }
        self.half_of.as_ref().map_or(Ok(()), Disc::check)
    }
}

/// Times at which points are lit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SunHours {
    /// Spans of all points, row by row, rising.
    spans: Vec<[f64; 2]>,
    /// End of each row in `spans`.
    ends: Vec<usize>,
    /// Accuracy, conventions and hash.
    pub stated: Stated,
}

impl SunHours {
    /// Returns the spans in which a point is lit (start and end, seconds), rising.
    ///
    /// # Panics
    /// Panics if there is no such row.
    pub fn spans(&self, row: usize) -> &[[f64; 2]] {
        let start = if row == 0 { 0 } else { self.ends[row - 1] };
        &self.spans[start..self.ends[row]]
    }

    /// Returns the lengths of the spans of a point, minutes.
    fn lengths(&self, row: usize) -> impl Iterator<Item = f64> {
        let spans = self.spans(row).iter();
        spans.map(|span| (span[1] - span[0]) / 60.0)
    }

    /// Returns the time for which a point is lit, minutes.
    ///
    /// # Panics
    /// Panics if there is no such row.
    pub fn minutes(&self, row: usize) -> f64 {
        self.lengths(row).fold(0.0, |sum, length| sum + length)
    }

    /// Returns the length of the longest span of a point, minutes.
    ///
    /// # Panics
    /// Panics if there is no such row.
    pub fn longest_minutes(&self, row: usize) -> f64 {
        self.lengths(row).fold(0.0, f64::max)
    }
}

/// A sample in time.
struct Sample {
    second: f64,
    /// `None` while the sun is below the horizon.
    frame: Option<DMat3>,
}

impl Facets {
    /// Returns the spans in which points are lit: samples in steps, and bisection between samples
    /// that differ. The sun is dark below the horizon, the plane across the up axis.
    ///
    /// `path` returns a vector of any length towards the sun at a time (seconds), in the caller's
    /// axes. `progress` receives the number of computed points from time to time. Undecided are
    /// points with an undecided sample.
    ///
    /// # Errors
    /// Errors if a setting of the day is out of range, or with the first sample at which the path's
    /// vector is zero or not finite.
    pub fn sun_hours(
        &self,
        points: &Points,
        path: &(impl Fn(f64) -> DVec3 + Sync),
        day: &Day,
        progress: impl FnMut(usize),
    ) -> Result<SunHours, FacetsError> {
        day.check()?;
        let steps = ((day.end_s - day.start_s) / day.step_s).ceil();
        let step = (day.end_s - day.start_s) / steps;
        let mut samples = Vec::new();
        for i in 0..=steps as usize {
            let second = day.start_s + step * i as f64;
            let direction = path(second);
            if !direction.is_finite() || direction == DVec3::ZERO {
                let why = format!("is {direction} at {second} s");
                let help = "return finite vectors, not zero";
                return Err(FacetsError::new("sun's path", why, help));
            }
            samples.push(Sample {
                second,
                frame: self.frame_above_horizon(direction),
            });
        }
        let rays = Rays::new(self, points);
        let watch = Watch { path, day, rays };
        let mut by_row = vec![PointSpans::default(); points.count()];
        points.visit_rows(
            |(): &mut (), row| watch.spans_of(row, &samples),
            |row, spans| by_row[row] = spans,
            progress,
        );
        let mut hours = SunHours {
            stated: Stated {
                margin_m: watch.rays.margin,
                step_s: Some(step),
                bisected_s: Some(day.bisect_s),
                disc_degrees: day.half_of.map(|disc| disc.radius_degrees),
                refraction: Some(day.refraction),
                ..Stated::default()
            },
            ..SunHours::default()
        };
        let mut hash = AnswerHash::new();
        for (row, point) in by_row.into_iter().enumerate() {
            let undecided = point.is_undecided.then_some((0, row as u32));
            hours.stated.add_undecided(undecided);
            hash.add_bits(point.spans.len() as u64);
            for span in &point.spans {
                hash.add(span[0]);
                hash.add(span[1]);
            }
            hours.spans.extend(point.spans);
            hours.ends.push(hours.spans.len());
        }
        hours.stated.keep_listed();
        hours.stated.hash = hash.finish();
        Ok(hours)
    }

    /// Returns the frame along a direction to the sun; `None` below the horizon.
    fn frame_above_horizon(&self, direction: DVec3) -> Option<DMat3> {
        let is_up = self.options().up.height(direction) > 0.0;
        is_up.then(|| frame_towards(direction.normalize()))
    }
}

/// The spans of a point.
#[derive(Clone, Debug, Default)]
struct PointSpans {
    spans: Vec<[f64; 2]>,
    is_undecided: bool,
}

/// What all points share.
struct Watch<'a, P> {
    path: &'a P,
    day: &'a Day,
    rays: Rays<'a>,
}

impl<P: Fn(f64) -> DVec3 + Sync> Watch<'_, P> {
    fn spans_of(&self, row: usize, samples: &[Sample]) -> PointSpans {
        let mut out = PointSpans::default();
        let mut blocker = NO_BLOCKER;
        // Times at which the point gets lit and dark in turn.
        let mut changes = Vec::new();
        let mut was_lit = false;
        let mut before = self.day.start_s;
        for sample in samples {
            let (is_lit, is_undecided) = self.is_lit(row, sample.frame.as_ref(), &mut blocker);
            out.is_undecided |= is_undecided;
            if is_lit != was_lit {
                changes.push(self.bisect(row, [before, sample.second], was_lit, &mut blocker));
            }
            was_lit = is_lit;
            before = sample.second;
        }
        if was_lit {
            changes.push(before);
        }
        for span in changes.chunks_exact(2) {
            self.add_span(&mut out.spans, span[0], span[1]);
        }
        out
    }

    /// Returns whether a point is lit, and whether that is undecided. `blocker` is the facet that
    /// shaded it last.
    fn is_lit(&self, row: usize, frame: Option<&DMat3>, blocker: &mut u32) -> (bool, bool) {
        let Some(frame) = frame else {
            return (false, false);
        };
        if let Some(disc) = &self.day.half_of {
            let [share, error] = disc_seen(&self.rays, row, frame, disc);
            return (share >= 0.5, (share - 0.5).abs() <= error);
        }
        let answer = self.rays.answer(row, frame, *blocker);
        if answer.blocker != NO_BLOCKER {
            *blocker = answer.blocker;
        }
        (answer.is_lit, answer.is_undecided)
    }

    /// Returns the time between two at which the point changes.
    fn bisect(&self, row: usize, between: [f64; 2], was_lit: bool, blocker: &mut u32) -> f64 {
        let [mut low, mut high] = between;
        // Halve until the middle is within the tolerance of both ends, or equals one.
        while high - low > 2.0 * self.day.bisect_s {
            let middle = low.midpoint(high);
            if middle <= low || middle >= high {
                break;
            }
            let direction = (self.path)(middle);
            let frame = self.rays.facets.frame_above_horizon(direction);
            let (is_lit, _) = self.is_lit(row, frame.as_ref(), blocker);
            if is_lit == was_lit {
                low = middle;
            } else {
                high = middle;
            }
        }
        low.midpoint(high)
    }

    /// Appends the parts of a span within the windows.
    fn add_span(&self, spans: &mut Vec<[f64; 2]>, start_s: f64, end_s: f64) {
        if self.day.windows.is_empty() {
            spans.push([start_s, end_s]);
        }
        for window in &self.day.windows {
            let span = [start_s.max(window[0]), end_s.min(window[1])];
            if span[0] < span[1] {
                spans.push(span);
            }
        }
    }
}
