//! The chart of time against error, one a scene.

use crate::{
    compare::{Measured, Row, SceneResult},
    pareto,
};
use plotly::{
    Plot, Scatter,
    common::{DashType, HoverInfo, Line, Marker, MarkerSymbol, Mode},
};

/// Logarithmic axes have no zero: errors below this are drawn here (a fortieth of a step of an 8-bit image)...
const LEAST_ERROR: f64 = 1e-4;
/// ... and times below this, milliseconds: a tenth of a microsecond.
const LEAST_TIME: f64 = 1e-4;

/// Colours of backends, readable on light and dark: blue and orange; any third is grey.
fn color(backend: usize) -> &'static str {
    ["#3b82e0", "#ea7317"].get(backend).copied().unwrap_or("#8a94a3")
}

/// Shapes of techniques, in the order in which they come.
fn symbol(technique: usize) -> MarkerSymbol {
    use MarkerSymbol as M;
    let all =
        [M::Circle, M::Diamond, M::Square, M::TriangleUp, M::Cross, M::TriangleDown, M::Hexagon, M::Pentagon, M::Star];
    all[technique % all.len()].clone()
}

/// The rows on their backends' Pareto fronts of time against error, and the chart's curves.
pub(super) fn of(result: &SceneResult) -> (Vec<usize>, serde_json::Value) {
    let (mut plot, mut on_front) = (Plot::new(), Vec::new());
    let techniques = distinct(result, |r| &r.technique);
    for (b, backend) in distinct(result, |r| &r.backend).into_iter().enumerate() {
        let rows: Vec<(usize, &Row, &Measured)> = result
            .rows
            .iter()
            .enumerate()
            .filter(|(_, r)| r.backend == backend)
            .filter_map(|(i, r)| Some((i, r, r.measured()?)))
            .collect();
        let front: Vec<_> = pareto::front(&rows.iter().map(|(.., m)| raw_point(m)).collect::<Vec<_>>());
        on_front.extend(front.iter().map(|&k| rows[k].0));
        plot.add_trace(front_line(&front.iter().map(|&k| point(rows[k].2)).collect::<Vec<_>>(), backend, b));
        for (t, technique) in techniques.iter().enumerate() {
            let of_technique: Vec<_> = rows.iter().filter(|(_, r, _)| r.technique == *technique).copied().collect();
            if !of_technique.is_empty() {
                plot.add_trace(points(&of_technique, technique, t, backend, b));
            }
        }
    }
    let traces = serde_json::to_value(plot.data()).unwrap_or_default();
    (on_front, traces)
}

fn distinct(result: &SceneResult, name: fn(&Row) -> &String) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for row in &result.rows {
        if !names.contains(&name(row).as_str()) {
            names.push(name(row));
        }
    }
    names
}

fn raw_point(m: &Measured) -> [f64; 2] {
    [m.times.total.median, m.errors.rmse]
}

fn point(m: &Measured) -> [f64; 2] {
    let [time, error] = raw_point(m);
    [time.max(LEAST_TIME), error.max(LEAST_ERROR)]
}

fn front_line(front: &[[f64; 2]], backend: &str, b: usize) -> Box<dyn plotly::Trace> {
    let (x, y) = front.iter().map(|p| (p[0], p[1])).unzip();
    Scatter::new(x, y)
        .mode(Mode::Lines)
        .name(format!("Pareto front, {}", text(backend)))
        .hover_info(HoverInfo::Skip)
        .line(Line::new().color(color(b)).width(1.5).dash(DashType::Dot))
}

fn points(
    rows: &[(usize, &Row, &Measured)],
    technique: &str,
    t: usize,
    backend: &str,
    b: usize,
) -> Box<dyn plotly::Trace> {
    let (x, y) = rows.iter().map(|(.., m)| (point(m)[0], point(m)[1])).unzip();
    Scatter::new(x, y)
        .mode(Mode::Markers)
        .name(format!("{}, {}", text(technique), text(backend)))
        .custom_data(rows.iter().map(|(i, ..)| *i as f64).collect::<Vec<_>>())
        .hover_info(HoverInfo::Text)
        .hover_text_array(rows.iter().map(|(_, r, m)| hover(r, m)).collect::<Vec<_>>())
        .marker(Marker::new().color(color(b)).symbol(symbol(t)).size(9).opacity(0.85))
}

fn hover(row: &Row, m: &Measured) -> String {
    let (e, total) = (&m.errors, m.times.total);
    let stage = |s: Option<crate::compare::Spread>| s.map_or("–".to_owned(), |s| format!("{:.3} ms", s.median));
    format!(
        "<b>{}</b> on {}<br>{}<br>RMSE {:.5}, mean {:.5}<br>false shadow {:.2} %, false light {:.2} %, acne {:.2} %<br>\
         cast {}, lookup {}, total {:.3} ms ({:.3} – {:.3})<br>{:.2} MB",
        text(&row.technique),
        text(&row.backend),
        text(&row.settings),
        e.rmse,
        e.mean,
        e.false_shadow,
        e.false_light,
        e.acne,
        stage(m.times.cast),
        stage(m.times.receive),
        total.median,
        total.least,
        total.greatest,
        m.bytes as f64 / 1e6,
    )
}

/// plotly.js reads its texts as a small markup: names must not be read so.
fn text(plain: &str) -> String {
    plain.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
