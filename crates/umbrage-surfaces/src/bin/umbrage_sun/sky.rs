//! Positions of the Sun: of a place and a day, or directions of a file.

use crate::cli::Arguments;
use anyhow::{Context as _, Result, bail, ensure};
use chrono::{Datelike as _, NaiveDate};
use solar_positioning::{
    Location, RefractionCorrection, SolarPositions, delta_t, time::JulianDate,
};
use std::fs;
use umbrage_surfaces::{Suns, Up, direction_at, glam::DVec3};

/// Seconds of a day.
pub(crate) const DAY_S: f64 = 86_400.0;

/// Suns to compute for.
#[derive(Clone, Debug)]
pub(crate) enum Sky {
    /// A day at a place.
    Day(LocalDay),
    /// Directions with weights.
    Directions(Suns),
}

/// A day at a place. Times are seconds after local midnight.
#[derive(Clone, Debug)]
pub(crate) struct LocalDay {
    location: Location,
    /// Local midnight, days, and the difference of terrestrial time and universal time, seconds.
    midnight: JulianDate,
    has_refraction: bool,
    pub(crate) step_s: f64,
    pub(crate) windows: Vec<[f64; 2]>,
    /// Description for outputs.
    pub(crate) title: String,
}

impl Sky {
    pub(crate) fn of_arguments(arguments: &Arguments) -> Result<Self> {
        if let Some(path) = &arguments.suns {
            let name = path.display();
            let text = fs::read_to_string(path).with_context(|| format!("{name} can't be read"))?;
            let directions = directions(&text).with_context(|| name.to_string())?;
            return Ok(Self::Directions(directions));
        }
        let (Some(place), Some(day)) = (arguments.place, arguments.on) else {
            bail!("give a place and a day (`--where`, `--on`), or `--suns`");
        };
        Ok(Self::Day(LocalDay::new(place, day, arguments)?))
    }
}

/// Reads lines `x y z [weight]`, separated by spaces or commas. Lines that begin with # are skipped.
fn directions(text: &str) -> Result<Suns> {
    let mut directions = Vec::new();
    let mut weights = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        if line.trim().is_empty() || line.starts_with('#') {
            continue;
        }
        let words = line.split([' ', ',', '\t']).filter(|word| !word.is_empty());
        let numbers: Result<Vec<f64>, _> = words.map(str::parse).collect();
        let (direction, weight) = match numbers.as_deref() {
            Ok(&[x, y, z]) => (DVec3::new(x, y, z), 1.0),
            Ok(&[x, y, z, weight]) => (DVec3::new(x, y, z), weight),
            _ => bail!("line {number}: `{line}` is not `x y z` or `x y z weight`"),
        };
        directions.push(direction);
        weights.push(weight);
    }
    ensure!(
        !directions.is_empty(),
        "has no directions; write `x y z` on a line"
    );
    Ok(Suns::with_weights(&directions, &weights)?)
}

impl LocalDay {
    fn new(place: [f64; 2], day: NaiveDate, arguments: &Arguments) -> Result<Self> {
        let [latitude, longitude] = place;
        let zone = arguments.zone;
        let title = format!("{day} at {latitude}, {longitude}, UTC{zone:+} h");
        let at_start = || -> Result<Self, solar_positioning::Error> {
            let delta_t = delta_t::estimate_from_date(day.year(), day.month())?;
            let (year, month, day) = (day.year(), day.month(), day.day());
            let noon = JulianDate::from_utc(year, month, day, 12, 0, 0.0, delta_t)?;
            let midnight = noon.julian_date() - 0.5 - zone / 24.0;
            let local = Self {
                location: Location {
                    latitude,
                    longitude,
                },
                midnight: JulianDate::new(midnight, delta_t)?,
                has_refraction: arguments.refraction,
                step_s: arguments.step,
                windows: arguments.window.clone(),
                title: title.clone()
                    + if arguments.refraction {
                        ", refraction"
                    } else {
                        ""
                    },
            };
            // Coordinates and years out of range are errors here, and not at each second.
            local.position(0.0)?;
            local.position(DAY_S)?;
            Ok(local)
        };
        at_start().with_context(|| format!("`--where`, `--on` and `--zone`: {title}"))
    }

    fn position(&self, second: f64) -> solar_positioning::Result<[f64; 2]> {
        let days = self.midnight.julian_date() + second / DAY_S;
        let time = JulianDate::new(days, self.midnight.delta_t())?;
        let refraction = self.has_refraction.then(RefractionCorrection::standard);
        let sun = SolarPositions::new().at_from_julian(time, self.location, 0.0, refraction)?;
        Ok([sun.azimuth(), sun.elevation_angle()])
    }

    /// Returns the direction to the Sun, zero if it can't be computed: callers report zero.
    pub(crate) fn direction(&self, second: f64, up: Up) -> DVec3 {
        match self.position(second) {
            Ok([azimuth, height]) => direction_at(azimuth, height, up),
            Err(_) => DVec3::ZERO,
        }
    }

    /// Returns the directions at the middles of all steps with the Sun above the horizon, with the
    /// hours of each step that are within the windows.
    pub(crate) fn steps(&self, up: Up) -> Result<Suns> {
        let steps = (DAY_S / self.step_s).ceil();
        let step = DAY_S / steps;
        let whole = [[0.0, DAY_S]];
        let windows = if self.windows.is_empty() {
            &whole[..]
        } else {
            &self.windows
        };
        let mut directions = Vec::new();
        let mut weights = Vec::new();
        for i in 0..steps as usize {
            let start = step * i as f64;
            let within = |window: &[f64; 2]| {
                let end = window[1].min(start + step);
                (end - window[0].max(start)).max(0.0)
            };
            let hours = windows.iter().map(within).sum::<f64>() / 3600.0;
            let direction = self.direction(start + step / 2.0, up);
            if hours > 0.0 && up.height(direction) > 0.0 {
                directions.push(direction);
                weights.push(hours);
            }
        }
        Ok(Suns::with_weights(&directions, &weights)?)
    }
}
