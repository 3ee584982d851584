//! The interactive charts: time against error, one a scene, and one over all scenes.

use super::{
    chosen,
    style::{SeriesStyle, color, styles_of},
};
use crate::{
    compare::{
        CompareRow, CostBasis, MIN_ERROR as MIN_RELATIVE_ERROR, Measured, Relative, SceneResult,
        TimingStats,
    },
    output::{figure::Marker as Shape, html::escape},
};
use plotly::{
    Plot, Scatter,
    common::{DashType, ErrorData, ErrorType, HoverInfo, Line, Marker, MarkerSymbol, Mode},
};
use umbrage_plan::pareto;

/// Logarithmic axes have no zero: errors below this are drawn here (a fortieth of a step of an 8-bit image)...
const MIN_ERROR: f64 = 1e-4;
/// ... and times below this, milliseconds: a tenth of a microsecond.
const MIN_TIME: f64 = 1e-4;

/// The shape that the still draws, by plotly.js's name.
fn symbol(shape: Shape) -> MarkerSymbol {
    match shape {
        Shape::Circle => MarkerSymbol::Circle,
        Shape::Square => MarkerSymbol::Square,
        Shape::Diamond => MarkerSymbol::Diamond,
        Shape::Triangle => MarkerSymbol::TriangleUp,
        Shape::TriangleDown => MarkerSymbol::TriangleDown,
        Shape::Cross => MarkerSymbol::X,
        Shape::Plus => MarkerSymbol::Cross,
        Shape::Star => MarkerSymbol::Star,
        Shape::Pentagon => MarkerSymbol::Pentagon,
        Shape::Hexagon => MarkerSymbol::Hexagon,
    }
}

/// A row as a point.
#[derive(Clone, Debug)]
pub(super) struct Dot {
    /// What a click on it leads to: the row's place.
    place: usize,
    pub(super) technique: String,
    pub(super) backend: String,
    pub(super) settings: String,
    pub(super) xy: [f64; 2],
    /// Quickest and slowest run.
    pub(super) range: Option<[f64; 2]>,
    pub(super) on_front: bool,
    hover: String,
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
        hover: format!(
            "<b>{}</b> on {}<br>{}<br>error {:.3} of no shadow's, time {:.2} of hard's<br>serves {} of {} scenes",
            escape(&r.technique),
            escape(&r.backend),
            escape(&r.settings),
            r.error,
            x,
            r.served,
            r.scenes,
        ),
    })
}

/// Places of the rows on a front.
pub(super) fn front(dots: &[Dot]) -> Vec<usize> {
    dots.iter()
        .filter(|d| d.on_front)
        .map(|d| d.place)
        .collect()
}

/// Curves for plotly.js: each backend's front, then each technique's points, those that the front beats faint.
pub(super) fn traces(dots: &[Dot]) -> serde_json::Value {
    let mut plot = Plot::new();
    let techniques = distinct(dots, |d| &d.technique);
    let styles = styles_of(&techniques);
    for (b, backend) in distinct(dots, |d| &d.backend).into_iter().enumerate() {
        let of_backend: Vec<&Dot> = dots.iter().filter(|d| d.backend == backend).collect();
        plot.add_trace(front_line(&of_backend, backend, b));
        for (technique, style) in techniques.iter().zip(&styles) {
            let of: Vec<&Dot> = of_backend
                .iter()
                .filter(|d| d.technique == *technique)
                .copied()
                .collect();
            let (best, beaten): (Vec<&Dot>, Vec<&Dot>) = of.into_iter().partition(|d| d.on_front);
            let in_legend = best.is_empty();
            for (dots, bright) in [(best, true), (beaten, false)] {
                if !dots.is_empty() {
                    let name = format!("{}, {}", escape(technique), escape(backend));
                    plot.add_trace(points(
                        &dots,
                        name,
                        *style,
                        b,
                        (bright, bright || in_legend),
                    ));
                }
            }
        }
    }
    serde_json::to_value(plot.data()).unwrap_or_default()
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

fn front_line(dots: &[&Dot], backend: &str, b: usize) -> Box<dyn plotly::Trace> {
    let mut front: Vec<[f64; 2]> = dots.iter().filter(|d| d.on_front).map(|d| d.xy).collect();
    front.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let (x, y) = front.iter().map(|p| (p[0], p[1])).unzip();
    Scatter::new(x, y)
        .mode(Mode::Lines)
        .name(format!("Pareto front, {}", escape(backend)))
        .hover_info(HoverInfo::Skip)
        .line(Line::new().color(color(b)).width(1.5).dash(DashType::Dot))
}

fn points(
    dots: &[&Dot],
    name: String,
    style: SeriesStyle,
    backend: usize,
    (bright, in_legend): (bool, bool),
) -> Box<dyn plotly::Trace> {
    let (x, y) = dots.iter().map(|d| (d.xy[0], d.xy[1])).unzip();
    let (size, opacity) = if bright { (10, 0.95) } else { (7, 0.28) };
    let (color, symbol) = (style.color(backend), symbol(style.marker));
    let mut trace = Scatter::new(x, y)
        .mode(Mode::Markers)
        .legend_group(name.clone())
        .name(name)
        .show_legend(in_legend)
        .custom_data(dots.iter().map(|d| d.place as f64).collect::<Vec<_>>())
        .hover_info(HoverInfo::Text)
        .hover_text_array(dots.iter().map(|d| d.hover.clone()).collect::<Vec<_>>())
        .marker(
            Marker::new()
                .color(color)
                .symbol(symbol)
                .size(size)
                .opacity(opacity),
        );
    // Bars on beaten points would hide the others.
    if bright && dots.iter().any(|d| d.range.is_some()) {
        let arm = |end: usize| {
            dots.iter()
                .map(|d| d.range.map_or(0.0, |r| (r[end] - d.xy[0]).abs()))
                .collect()
        };
        let bars = ErrorData::new(ErrorType::Data)
            .symmetric(false)
            .array(arm(1))
            .array_minus(arm(0));
        trace = trace.error_x(bars.color(color).thickness(1.0).width(3));
    }
    trace
}

fn hover(row: &CompareRow, m: &Measured) -> Option<String> {
    let e = m.errors?;
    let times = m.times.map_or_else(String::new, |t| {
        let stage =
            |s: Option<TimingStats>| s.map_or("–".to_owned(), |s| format!("{:.3} ms", s.median));
        let total = t.total;
        let [cast, lookup] = [stage(t.cast), stage(t.receive)];
        let runs = format!("{:.3} – {:.3} in {} runs", total.min, total.max, total.runs);
        format!(
            "<br>cast {cast}, lookup {lookup}, total {:.3} ms ({runs})",
            total.median
        )
    });
    let maps = m
        .maps
        .map_or_else(String::new, |maps| format!("<br>{}", maps.words()));
    Some(format!(
        "<b>{}</b> on {}<br>{}<br>RMSE {:.5}, mean {:.5}<br>false shadow {:.2} %, false light {:.2} %, acne {:.2} %{times}\
         <br>cost {:.3} ms, {:.2} MB{maps}",
        escape(&row.technique),
        escape(&row.backend),
        escape(&row.settings),
        e.rmse,
        e.mean,
        e.false_shadow,
        e.false_light,
        e.acne,
        m.cost_ms,
        m.bytes as f64 / 1e6,
    ))
}
