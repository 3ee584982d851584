//! The charts as SVG and PNG, for pages that cannot run a script.

use super::{
    chart::{Dot, distinct},
    style::{SeriesStyle, color, styles_of},
};
use crate::{
    compare::CostBasis,
    output::figure::{Figure, Key, Point, Series, Style},
};

/// Radius of points that the front beats, pixels.
const FAINT_RADIUS: f64 = 3.5;

/// What the axes say.
pub(super) struct Words<'a> {
    pub(super) title: &'a str,
    pub(super) subtitle: String,
    pub(super) x: &'a str,
    pub(super) y: &'a str,
}

/// Words for all scenes.
pub(super) fn of_all(scenes: usize, clock: CostBasis) -> Words<'static> {
    let x = match clock {
        CostBasis::Wall => "time, relative to hard shadows from a map of middle size",
        CostBasis::Cost => "counted cost, relative to hard shadows from a map of middle size",
    };
    Words {
        title: "Speed against accuracy of every shadow technique",
        subtitle: format!("means over {scenes} scenes; down and left is better"),
        x,
        y: "error, relative to drawing no shadows",
    }
}

/// Each backend's front with its names, everything else faint: blue and orange as in the page.
pub(super) fn figure(dots: &[Dot], words: &Words<'_>) -> Figure {
    let mut figure = Figure::new(words.title, words.x, words.y).log(true, true);
    figure.subtitle.clone_from(&words.subtitle);
    figure.size = [980.0, 620.0];
    let techniques = distinct(dots, |d| &d.technique);
    let styles = styles_of(&techniques);
    let backends = distinct(dots, |d| &d.backend);
    let of = |technique: &str, backend: &str, on_front: bool| -> Vec<Point> {
        let mine =
            |d: &&Dot| d.technique == technique && d.backend == backend && d.on_front == on_front;
        dots.iter().filter(mine).map(point).collect()
    };
    // What is beaten lies below; one backend's shapes explain the other's.
    for (b, backend) in backends.iter().enumerate() {
        for (technique, style) in techniques.iter().zip(&styles) {
            let beaten = of(technique, backend, false);
            figure.series.push(Series {
                style: Style::Points(style.marker, FAINT_RADIUS, 1.0),
                ..Series::points("", style.faint(b), style.marker, beaten)
            });
        }
    }
    for (b, backend) in backends.iter().enumerate() {
        figure.series.push(front_line(dots, backend, b));
        for (technique, style) in techniques.iter().zip(&styles) {
            figure.series.push(Series::points(
                "",
                style.color(b),
                style.marker,
                of(technique, backend, true),
            ));
        }
    }
    let key = |(name, style): (&&str, &SeriesStyle)| Key {
        name: (*name).to_owned(),
        marker: style.marker,
        color: style.ink().to_owned(),
    };
    figure.keys = techniques.iter().zip(&styles).map(key).collect();
    figure.notes = notes(dots);
    figure
}

fn front_line(dots: &[Dot], backend: &str, b: usize) -> Series {
    let mut front: Vec<[f64; 2]> = dots
        .iter()
        .filter(|d| d.on_front && d.backend == backend)
        .map(|d| d.xy)
        .collect();
    front.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let corners = front.iter().map(|xy| Point::at(xy[0], xy[1])).collect();
    Series {
        style: Style::Dashed(1.5),
        ..Series::line(format!("Pareto front, {backend}"), color(b), corners)
    }
}

fn point(dot: &Dot) -> Point {
    Point {
        x_range: dot.range.filter(|_| dot.on_front),
        ..Point::at(dot.xy[0], dot.xy[1])
    }
}

/// Names of the points on fronts.
fn notes(dots: &[Dot]) -> Vec<Point> {
    let note = |d: &Dot| Point {
        label: short(d),
        ..Point::at(d.xy[0], d.xy[1])
    };
    dots.iter().filter(|d| d.on_front).map(note).collect()
}

/// A label short enough to stand in a chart: the technique and its first two settings.
fn short(dot: &Dot) -> String {
    let settings: Vec<&str> = dot.settings.split(", ").take(2).collect();
    format!("{} {}", dot.technique, settings.join(", "))
}
