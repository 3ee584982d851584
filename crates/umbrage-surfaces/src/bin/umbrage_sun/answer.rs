//! Numbers for each facet, and their sums.

use crate::{
    cli::Arguments,
    sky::{LocalDay, Sky},
};
use anyhow::{Result, ensure};
use indicatif::{ProgressBar, ProgressStyle};
use umbrage_surfaces::{Day, Disc, Facets, Points, Stated, Suns};

/// Names and values of a column; a value for each facet.
type Column = (&'static str, Vec<f64>);

/// Results for each facet.
pub(crate) struct FacetTable {
    /// Description of the computed quantity.
    pub(crate) title: String,
    /// Columns of numbers. Images are coloured by the first one.
    pub(crate) columns: Vec<Column>,
    /// Spans of light as text; empty without times.
    pub(crate) spans: Vec<String>,
    pub(crate) stated: Stated,
}

impl FacetTable {
    pub(crate) fn compute(facets: &Facets, sky: &Sky, arguments: &Arguments) -> Result<Self> {
        match sky {
            Sky::Day(day) if !arguments.area => Self::times(facets, day, arguments),
            Sky::Day(day) => {
                let steps = day.steps(facets.options().up)?;
                ensure!(
                    !steps.directions().is_empty(),
                    "the Sun is below the horizon on {}; choose another day or window",
                    day.title
                );
                let names = [
                    "hours",
                    "square_metre_hours",
                    "projected_square_metre_hours",
                ];
                let mut answer = Self::areas(facets, &steps, 1.0, names);
                answer.stated.step_s = Some(day.step_s);
                answer.stated.refraction = Some(arguments.refraction);
                answer.title = format!("lit areas on {}", day.title);
                Ok(answer)
            }
            Sky::Directions(suns) => {
                let whole: f64 = suns.weights().iter().sum();
                ensure!(
                    whole > 0.0,
                    "the weights of suns sum to {whole}; use a positive sum"
                );
                let mut answer = if arguments.area {
                    let names = ["lit_share", "lit_m2", "projected_m2"];
                    Self::areas(facets, suns, 1.0 / whole, names)
                } else {
                    Self::centres(facets, suns, 1.0 / whole)
                };
                answer.title = format!("{} directions, weighted mean", suns.directions().len());
                Ok(answer)
            }
        }
    }

    /// Computes the times at which centres are lit.
    fn times(facets: &Facets, local: &LocalDay, arguments: &Arguments) -> Result<Self> {
        let day = Day {
            step_s: local.step_s,
            windows: local.windows.clone(),
            half_of: arguments.half_disc.then(Disc::default),
            refraction: arguments.refraction,
            ..Day::default()
        };
        let progress = progress(facets.count(), "points");
        let up = facets.options().up;
        let path = |second: f64| local.direction(second, up);
        let hours = facets.sun_hours(&Points::centres_of(facets), &path, &day, |count| {
            progress.set_position(count as u64);
        })?;
        progress.finish_and_clear();
        let rows = 0..facets.count();
        let whole = rows.clone().map(|row| hours.minutes(row) / 60.0);
        let longest = rows.clone().map(|row| hours.longest_minutes(row) / 60.0);
        let spans = rows.map(|row| text_of_spans(hours.spans(row))).collect();
        Ok(Self {
            title: format!("hours of sun of facets' centres on {}", local.title),
            columns: vec![
                ("hours", whole.collect()),
                ("longest_hours", longest.collect()),
            ],
            spans,
            stated: hours.stated,
        })
    }

    /// Sums the lit areas of all suns by their weights, times a scale.
    fn areas(facets: &Facets, suns: &Suns, scale: f64, names: [&'static str; 3]) -> Self {
        let mut sums = names.map(|name| (name, vec![0.0; facets.count()]));
        let progress = progress(suns.directions().len(), "suns");
        let stated = facets.lit_area(suns, |sun, areas| {
            let weight = suns.weights()[sun] * scale;
            for (row, lit) in areas.iter().enumerate() {
                sums[0].1[row] += weight * lit.fraction;
                sums[1].1[row] += weight * lit.area;
                sums[2].1[row] += weight * lit.projected;
            }
            progress.inc(1);
        });
        progress.finish_and_clear();
        Self {
            title: String::new(),
            columns: sums.into(),
            spans: Vec::new(),
            stated,
        }
    }

    /// Sums the suns that light the facets' centres by their weights, times a scale.
    fn centres(facets: &Facets, suns: &Suns, scale: f64) -> Self {
        let progress = progress(facets.count(), "points");
        let lit = facets.lit(&Points::centres_of(facets), suns, |count| {
            progress.set_position(count as u64);
        });
        progress.finish_and_clear();
        let share = |row: usize| -> f64 {
            let weights = suns.weights().iter().enumerate();
            let lit = weights.filter(|&(sun, _)| lit.is_lit(sun, row));
            lit.map(|(_, weight)| weight * scale).sum()
        };
        let shares = (0..facets.count()).map(share).collect();
        Self {
            title: String::new(),
            columns: vec![("lit_share", shares)],
            spans: Vec::new(),
            stated: lit.stated,
        }
    }

    /// Returns the numbers that images are coloured by: the first column.
    pub(crate) fn shades(&self) -> &[f64] {
        &self.columns[0].1
    }

    /// Returns the name of these numbers.
    pub(crate) fn shade_name(&self) -> &'static str {
        self.columns[0].0
    }

    /// Returns lines with the totals and the stated accuracy.
    pub(crate) fn report(&self, facets: &Facets) -> Vec<String> {
        let area: f64 = (0..facets.count()).map(|row| facets.area_m2(row)).sum();
        let weighted = |(row, shade): (usize, &f64)| shade * facets.area_m2(row);
        let shades = self.shades();
        let sum: f64 = shades.iter().enumerate().map(weighted).sum();
        let least = shades.iter().copied().fold(f64::INFINITY, f64::min);
        let most = shades.iter().copied().fold(0.0, f64::max);
        // A model without area has no mean.
        let mean = if area > 0.0 { sum / area } else { 0.0 };
        let mut lines = vec![
            self.title.clone(),
            format!("{} facets, {area:.3} m2", facets.count()),
            format!(
                "{}: mean by area {mean:.4}, least {least:.4}, most {most:.4}",
                self.shade_name()
            ),
        ];
        for (name, values) in self.columns.iter().skip(1) {
            if name.contains("m2") || name.contains("metre") {
                lines.push(format!("{name}: {:.6} in all", values.iter().sum::<f64>()));
            }
        }
        lines.push(format!("stated: {}", self.stated));
        lines
    }
}

/// Returns spans as `8:00:12-11:30:00;..`.
fn text_of_spans(spans: &[[f64; 2]]) -> String {
    let clock = |second: f64| {
        let second = second.round() as u64;
        let [hours, minutes] = [second / 3600, second / 60 % 60];
        format!("{hours}:{minutes:02}:{:02}", second % 60)
    };
    let spans = spans.iter();
    let texts: Vec<String> = spans
        .map(|&[start, end]| format!("{}-{}", clock(start), clock(end)))
        .collect();
    texts.join(";")
}

/// Returns a bar on standard error. It is hidden if standard error is no terminal.
fn progress(steps: usize, what: &'static str) -> ProgressBar {
    let bar = ProgressBar::new(steps as u64).with_message(what);
    match ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len}, {eta} left") {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
