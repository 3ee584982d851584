//! The points of the charts of time against error: one chart for each scene, and one over all scenes.

use super::chosen;
use crate::compare::{
    CompareRow, CostBasis, MIN_ERROR as MIN_RELATIVE_ERROR, Measured, Motion, Relative,
    SceneResult, TimingStats,
};
use serde::Serialize;
use umbrage_plan::pareto;

/// The least error that is drawn, a fortieth of a step of an 8-bit image. Smaller ones are drawn here, as logarithmic axes have
/// no zero.
const MIN_ERROR: f64 = 1e-4;
/// The least time that is drawn, milliseconds: a tenth of a microsecond. Shorter ones are drawn here.
const MIN_TIME: f64 = 1e-4;

/// A row as a point. The page's script is given what it shows and by what it filters.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Dot {
    /// The row's place, to which a click leads.
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

/// Returns a scene's rows by one clock, without those that weren't timed by it.
pub(super) fn dots(result: &SceneResult, clock: CostBasis) -> Vec<Dot> {
    let front = chosen::fronts(result, clock);
    let mut out = Vec::new();
    for (place, row) in result.rows.iter().enumerate() {
        if row.same_as.is_some() {
            continue;
        }
        if let Some(dot) = row_dot(place, row, clock, result.motion) {
            let on_front = front.contains(&place);
            out.push(Dot { on_front, ..dot });
        }
    }
    out
}

/// Returns a row as a dot that is on no front; none if it has no time or no error.
fn row_dot(place: usize, row: &CompareRow, clock: CostBasis, motion: Motion) -> Option<Dot> {
    let measured = row.measured()?;
    let frame_ms = measured.milliseconds(clock, motion)?;
    let x = frame_ms.max(MIN_TIME);
    let y = measured.rmse()?.max(MIN_ERROR);
    let range = match (clock, measured.times) {
        (CostBasis::Wall, Some(times)) => {
            // The frame's parts vary about as its casts, filters and lookup do together.
            let per_total = frame_ms / times.total.median.max(MIN_TIME);
            let ends = [times.total.min, times.total.max];
            Some(ends.map(|ms| (ms * per_total).max(MIN_TIME)))
        }
        _ => None,
    };
    Some(Dot {
        place,
        technique: row.technique.clone(),
        backend: row.backend.clone(),
        settings: row.settings.clone(),
        xy: [x, y],
        range,
        on_front: false,
        hover: hover(row, measured)?,
    })
}

/// Returns all scenes' settings by one clock.
pub(super) fn relative_dots(all: &[Relative], clock: CostBasis) -> Vec<Dot> {
    let mut dots: Vec<Dot> = all
        .iter()
        .enumerate()
        .filter_map(|(i, r)| relative_dot(i, r, clock))
        .collect();
    let mut backends: Vec<String> = dots.iter().map(|d| d.backend.clone()).collect();
    backends.sort_unstable();
    backends.dedup();
    for backend in backends {
        let of_backend: Vec<usize> = (0..dots.len())
            .filter(|&i| dots[i].backend == backend)
            .collect();
        let points: Vec<[f64; 2]> = of_backend.iter().map(|&i| dots[i].xy).collect();
        for on_front in pareto::front(&points) {
            dots[of_backend[on_front]].on_front = true;
        }
    }
    dots
}

fn relative_dot(place: usize, r: &Relative, clock: CostBasis) -> Option<Dot> {
    let x = r.take(clock)?;
    let range = match (clock, r.time) {
        (CostBasis::Wall, Some(time)) => Some([time.min, time.max]),
        _ => None,
    };
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

/// Returns the places of the rows on a front.
pub(super) fn front(dots: &[Dot]) -> Vec<usize> {
    dots.iter()
        .filter(|d| d.on_front)
        .map(|d| d.place)
        .collect()
}

/// Returns the distinct names of dots, in the order of their first dot.
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
    if let Some(preparation) = measured.preparation {
        let kept = if measured.kept_as_camera_moves {
            "kept while the camera moves"
        } else {
            "drawn anew as the camera moves"
        };
        lines.push(format!(
            "once a scene {:.1} ms, recipe {:.2} ms, {kept}",
            preparation.scene_ms, preparation.recipe.median
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
