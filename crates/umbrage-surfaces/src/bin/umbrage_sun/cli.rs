//! Arguments of the command.

use crate::sky::DAY_S;
use chrono::NaiveDate;
use clap::Parser;
use std::path::PathBuf;
use umbrage_surfaces::{Sides, Up, metres_of_unit};

/// Hours of sun and lit areas of the facets of a model, each with its stated error
#[derive(Parser, Clone, Debug)]
#[command(
    version,
    after_help = "Examples:
  umbrage-sun city.obj --where 48.1,11.6 --on 2026-03-21 --zone 1 --window 8-16 --out sun.csv
      hours of sun of each facet's centre in Munich, between 8 and 16 o'clock
  umbrage-sun model.glb --up z --unit cm --where 48.1,11.6 --on 2026-03-21 --step 5m --area --out sun.png
      exact lit areas every 5 minutes, and an image coloured by hours
  umbrage-sun satellite.obj --unit m --suns directions.txt --area --out lit.npy --out lit.glb
      mean lit and projected areas towards the directions `x y z weight` of a file"
)]
pub(crate) struct Arguments {
    /// Model: .obj, .glb or .gltf; nothing is added to it
    pub(crate) model: PathBuf,
    /// Axis that points up: y (-z is north: glTF) or z (y is north: CAD, GIS)
    /// [default: y for glTF, z for OBJ]
    #[arg(long)]
    pub(crate) up: Option<Up>,
    /// Unit of the model: m, cm, mm, km, ft, in, or the metres of one unit [default: metres; improbable sizes are an error]
    #[arg(long, value_parser = metres_of_unit)]
    pub(crate) unit: Option<f64>,
    /// Sides that receive and cast: front or both; front needs closed bodies and is faster
    #[arg(long, default_value = "both")]
    pub(crate) sides: Sides,
    /// Latitude (north) and longitude (east), degrees
    #[arg(
        long = "where",
        value_name = "LAT,LON",
        requires = "on",
        allow_hyphen_values = true,
        value_parser = place
    )]
    pub(crate) place: Option<[f64; 2]>,
    /// Day
    #[arg(long, value_name = "YYYY-MM-DD", requires = "place")]
    pub(crate) on: Option<NaiveDate>,
    /// Hours that local time is ahead of UTC
    #[arg(
        long,
        value_name = "HOURS",
        default_value_t = 0.0,
        allow_hyphen_values = true,
        value_parser = zone
    )]
    pub(crate) zone: f64,
    /// Step in time: 1m, 30s, or seconds
    #[arg(long, default_value = "1m", value_parser = step)]
    pub(crate) step: f64,
    /// Hours that count, local time; may be repeated [default: all of the day]
    #[arg(long, value_name = "FROM-TO", value_parser = window)]
    pub(crate) window: Vec<[f64; 2]>,
    /// Include refraction in the Sun's heights
    #[arg(long, requires = "place")]
    pub(crate) refraction: bool,
    /// A point is lit while it sees half of the Sun's disc, instead of its centre
    #[arg(long, requires = "place", conflicts_with_all = ["area", "suns"])]
    pub(crate) half_disc: bool,
    /// File of directions `x y z [weight]` towards suns, one a line, in the model's axes
    #[arg(long, value_name = "FILE", conflicts_with = "place")]
    pub(crate) suns: Option<PathBuf>,
    /// Exact lit areas, instead of the facets' centres
    #[arg(long)]
    pub(crate) area: bool,
    /// Output: .csv, .npy, .glb or .png; may be repeated
    #[arg(long, value_name = "FILE")]
    pub(crate) out: Vec<PathBuf>,
}

/// Reads a latitude and a longitude.
fn place(text: &str) -> Result<[f64; 2], &'static str> {
    let numbers = text.split_once(',').and_then(|(latitude, longitude)| {
        let latitude: f64 = latitude.trim().parse().ok()?;
        Some([latitude, longitude.trim().parse().ok()?])
    });
    numbers.ok_or("use degrees north and east, such as 48.1,11.6")
}

/// Reads hours that local time is ahead of UTC.
fn zone(text: &str) -> Result<f64, &'static str> {
    let hours = text.parse().ok();
    let hours = hours.filter(|hours| (-14.0..=14.0).contains(hours));
    hours.ok_or("use hours from -14 to 14")
}

/// Reads a step (`1m`, `30s`, `60`) as seconds.
fn step(text: &str) -> Result<f64, &'static str> {
    let (number, unit) = match text.strip_suffix('m') {
        Some(number) => (number, 60.0),
        None => (text.strip_suffix('s').unwrap_or(text), 1.0),
    };
    let seconds = number.parse::<f64>().ok().map(|number| number * unit);
    let seconds = seconds.filter(|seconds| (1.0..=DAY_S).contains(seconds));
    seconds.ok_or("use 1s to 1440m, such as 1m")
}

/// Reads a window (`8-16`, `8:30-16:15`) as seconds.
fn window(text: &str) -> Result<[f64; 2], &'static str> {
    let clock = |text: &str| -> Option<f64> {
        let (hours, minutes) = text.split_once(':').unwrap_or((text, "0"));
        let hours: f64 = hours.parse().ok()?;
        Some(hours * 3600.0 + minutes.parse::<f64>().ok()? * 60.0)
    };
    let ends = text.split_once('-');
    let ends = ends.and_then(|(from, to)| Some([clock(from)?, clock(to)?]));
    let ends = ends.filter(|[from, to]| 0.0 <= *from && from < to && *to <= DAY_S);
    ends.ok_or("use hours of the day, such as 8-16 or 8:30-16")
}
