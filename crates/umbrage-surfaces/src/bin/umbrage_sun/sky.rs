//! Positions of the Sun: of a place and a day, or directions of a file.

use crate::cli::Arguments;
use anyhow::{Context as _, Result, bail, ensure};
use solar_positioning::{
    Location, RefractionCorrection, SolarPositions, delta_t, time::JulianDate,
};
use std::fs;
use umbrage_surfaces::{Suns, Up, direction_at, glam::DVec3};

/// Seconds of a day.
const DAY_S: f64 = 86_400.0;

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
        let (Some(place), Some(day)) = (&arguments.place, &arguments.on) else {
            bail!("give a place and a day (`--where`, `--on`), or `--suns`");
        };
        let day = LocalDay::new(place, day, arguments)?;
        Ok(Self::Day(day))
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
    fn new(place: &str, day: &str, arguments: &Arguments) -> Result<Self> {
        let coordinates = place.split_once(',').and_then(|(latitude, longitude)| {
            let latitude: f64 = latitude.trim().parse().ok()?;
            Some([latitude, longitude.trim().parse().ok()?])
        });
        let Some([latitude, longitude]) = coordinates else {
            bail!("`--where {place}`: use degrees north and east, such as 48.1,11.6");
        };
        let date = || -> Option<(i32, u32, u32)> {
            let mut parts = day.splitn(3, '-');
            let year = parts.next()?.parse().ok()?;
            Some((
                year,
                parts.next()?.parse().ok()?,
                parts.next()?.parse().ok()?,
            ))
        };
        let (year, month, day_of_month) =
            date().with_context(|| format!("`--on {day}`: use a date such as 2026-03-21"))?;
        let delta_t =
            delta_t::estimate_from_date(year, month).with_context(|| format!("`--on {day}`"))?;
        let noon = JulianDate::from_utc(year, month, day_of_month, 12, 0, 0.0, delta_t)
            .with_context(|| format!("`--on {day}`"))?;
        ensure!(
            arguments.zone.abs() <= 14.0,
            "`--zone {}`: use hours from -14 to 14",
            arguments.zone
        );
        let midnight = noon.julian_date() - 0.5 - arguments.zone / 24.0;
        let windows: Result<Vec<_>> = arguments.window.iter().map(|text| window(text)).collect();
        let refraction = if arguments.refraction {
            ", refraction"
        } else {
            ""
        };
        let local = Self {
            location: Location {
                latitude,
                longitude,
            },
            midnight: JulianDate::new(midnight, delta_t)?,
            has_refraction: arguments.refraction,
            step_s: step(&arguments.step)?,
            windows: windows?,
            title: format!(
                "{day} at {latitude}, {longitude}, UTC{:+} h{refraction}",
                arguments.zone
            ),
        };
        // Coordinates and years out of range are errors here, and not at each second.
        local
            .position(0.0)
            .and_then(|_| local.position(DAY_S))
            .with_context(|| format!("`--where {place} --on {day}`"))?;
        Ok(local)
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

/// Reads a step (`1m`, `30s`, `60`) as seconds.
fn step(text: &str) -> Result<f64> {
    let (number, unit) = match text.strip_suffix('m') {
        Some(number) => (number, 60.0),
        None => (text.strip_suffix('s').unwrap_or(text), 1.0),
    };
    let seconds = number.parse::<f64>().unwrap_or(f64::NAN) * unit;
    ensure!(
        (1.0..=DAY_S).contains(&seconds),
        "`--step {text}`: use 1s to 1440m, such as 1m"
    );
    Ok(seconds)
}

/// Reads a window (`8-16`, `8:30-16:15`) as seconds.
fn window(text: &str) -> Result<[f64; 2]> {
    let clock = |text: &str| -> Option<f64> {
        let (hours, minutes) = text.split_once(':').unwrap_or((text, "0"));
        let hours: f64 = hours.parse().ok()?;
        Some(hours * 3600.0 + minutes.parse::<f64>().ok()? * 60.0)
    };
    let ends = text.split_once('-');
    let ends = ends.and_then(|(from, to)| Some([clock(from)?, clock(to)?]));
    match ends {
        Some([from, to]) if 0.0 <= from && from < to && to <= DAY_S => Ok([from, to]),
        _ => bail!("`--window {text}`: use hours of the day, such as 8-16 or 8:30-16"),
    }
}
