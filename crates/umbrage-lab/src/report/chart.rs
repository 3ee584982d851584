//! What the charts show: time against error, one chart a scene, and one over all scenes.

use super::chosen;
use crate::compare::{
    CompareRow, CostBasis, MIN_ERROR as MIN_RELATIVE_ERROR, Measured, Relative, SceneResult,
    TimingStats,
};
use serde::Serialize;
use umbrage_plan::pareto;

/// Logarithmic axes have no zero: errors below this are drawn here (a fortieth of a step of an 8-bit image)...
const MIN_ERROR: f64 = 1e-4;
/// ... and times below this, milliseconds: a tenth of a microsecond.
const MIN_TIME: f64 = 1e-4;

/// A row as a point. The page's script is given what it shows and by what it filters.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Dot {
    /// What a click on it leads to: the row's place.
    pub(super) place: usize,
    pub(super) technique: String,
    pub(super) backend: String,
    #[serde(skip)]
    pub(super) settings: String,
    #[serde(skip)]
    pub(super) xy: [f64; 2],
    /// Quickest and slowest run.
    #[serde(skip)]
    pub(super) range: Option<[f64; 2]>,
    #[serde(skip)]
    pub(super) on_front: bool,
    /// Lines of text that the page shows under the pointer.
    pub(super) hover: Vec<String>,
}

/// A scene's rows by one clock; none if they weren't timed by it.
pub(super) fn dots(result: &SceneResult, clock: CostBasis) -> Vec<Dot> {
    let front = chosen::fronts(result, clock);
    let dot = |(i, row): (usize, &CompareRow)| {
        let m = row.measured()?;
        let range = |t: TimingStats| [t.min, t.max].map(|t| t.max(MIN_TIME));
        Some(Dot {
            place: i,
            technique: row.technique.clone(),
            backend: row.backend.clone(),
            settings: row.settings.clone(),
            xy: [
                m.milliseconds(clock)?.max(MIN_TIME),
                m.rmse()?.max(MIN_ERROR),
            ],
            range: m
                .times
                .filter(|_| clock == CostBasis::Wall)
                .map(|t| range(t.total)),
            on_front: front.contains(&i),
            hover: hover(row, m)?,
        })
    };
    result.rows.iter().enumerate().filter_map(dot).collect()
}

/// All scenes' settings by one clock.
pub(super) fn relative_dots(all: &[Relative], clock: CostBasis) -> Vec<Dot> {
    let mut dots: Vec<Dot> = all
        .iter()
        .enumerate()
        .filter_map(|(i, r)| relative_dot(i, r, clock))
        .collect();
    let mut backends: Vec<String> = dots.iter().map(|d| d.backend.clone()).collect();
    backends.dedup();
    for backend in backends {
        let of: Vec<usize> = (0..dots.len())
            .filter(|&i| dots[i].backend == backend)
            .collect();
        let points: Vec<[f64; 2]> = of.iter().map(|&i| dots[i].xy).collect();
        pareto::front(&points)
            .into_iter()
            .for_each(|k| dots[of[k]].on_front = true);
    }
    dots
}

fn relative_dot(place: usize, r: &Relative, clock: CostBasis) -> Option<Dot> {
    let x = r.take(clock)?;
    let range = r
        .time
        .filter(|_| clock == CostBasis::Wall)
        .map(|t| [t.min, t.max]);
    Some(Dot {
        place,
        technique: r.technique.clone(),
        backend: r.backend.clone(),
        settings: r.settings.clone(),
        xy: [x, r.error.max(MIN_RELATIVE_ERROR)],
        range,
        on_front: false,
        hover: vec![
            format!("{} on {}", r.technique, r.backend),
            r.settings.clone(),
            format!("error {:.3} of no shadow's, time {x:.2} of hard's", r.error),
            format!("serves {} of {} scenes", r.served, r.scenes),
        ],
    })
}

/// Places of the rows on a front.
pub(super) fn front(dots: &[Dot]) -> Vec<usize> {
    dots.iter()
        .filter(|d| d.on_front)
        .map(|d| d.place)
        .collect()
}

pub(super) fn distinct(dots: &[Dot], name: fn(&Dot) -> &String) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for dot in dots {
        if !names.contains(&name(dot).as_str()) {
            names.push(name(dot));
        }
    }
    names
}

/// Returns what the page tells of a row under the pointer; none where no pixel counts.
fn hover(row: &CompareRow, measured: &Measured) -> Option<Vec<String>> {
    let errors = measured.errors?;
    let mut lines = vec![
        format!("{} on {}", row.technique, row.backend),
        row.settings.clone(),
        format!("RMSE {:.5}, mean {:.5}", errors.rmse, errors.mean),
        format!(
            "false shadow {:.2} %, false light {:.2} %, acne {:.2} %",
            errors.false_shadow, errors.false_light, errors.acne
        ),
    ];
    if let Some(times) = measured.times {
        let cast = median(times.cast);
        let lookup = median(times.receive);
        let total = times.total;
        lines.push(format!(
            "cast {cast}, lookup {lookup}, total {:.3} ms",
            total.median
        ));
        lines.push(format!(
            "{:.3} – {:.3} ms in {} runs",
            total.min, total.max, total.runs
        ));
    }
    let megabytes = measured.bytes as f64 / 1e6;
    lines.push(format!(
        "cost {:.3} ms, {megabytes:.2} MB",
        measured.cost_ms
    ));
    if let Some(maps) = measured.maps {
        lines.push(maps.words());
    }
    Some(lines)
}

/// Returns a stage's time as text; a dash where it was not timed.
fn median(stage: Option<TimingStats>) -> String {
    stage.map_or("–".to_owned(), |s| format!("{:.3} ms", s.median))
}
