//! Charts over many scenes as SVG and PNG, for places that cannot run a script.

use super::{
    chart::{Dot, distinct},
    style::{SeriesStyle, color, styles_of},
};
use crate::{
    compare::{CostBasis, FrameMotion, Section},
    output::figure::{Figure, Key, Point, Reference, Series, Style},
};

/// Radius of points behind the front, pixels.
const FAINT_RADIUS: f64 = 3.5;

/// A chart's title and the names of its axes.
pub(super) struct StillWords<'a> {
    pub(super) title: String,
    pub(super) subtitle: String,
    pub(super) x: &'a str,
    pub(super) y: &'a str,
}

/// Subject of a chart over many scenes.
pub(super) struct GroupWords<'a> {
    pub(super) scenes: usize,
    /// `hard` or `soft`.
    pub(super) light: &'a str,
    pub(super) section: Section,
    pub(super) motion: FrameMotion,
    pub(super) backend: &'a str,
    pub(super) clock: CostBasis,
}

/// Returns the texts of a chart over many scenes.
pub(super) fn of_group(group: &GroupWords<'_>) -> StillWords<'static> {
    let x = match group.clock {
        CostBasis::Wall => "time of a frame, relative to hard shadows from a map of middle size",
        CostBasis::Cost => {
            "counted cost of a frame, relative to hard shadows from a map of middle size"
        }
    };
    let kind = match group.section {
        Section::Content => "of real size",
        Section::Check => "small",
    };
    let scenes = if group.scenes == 1 {
        format!("on 1 scene, {kind}")
    } else {
        format!("means over {} scenes, {kind}", group.scenes)
    };
    let motion = group.motion.words();
    StillWords {
        title: format!(
            "Speed against accuracy of {} shadows on {}",
            group.light, group.backend
        ),
        subtitle: format!("{scenes}; {motion}; down and left is better"),
        x,
        y: "error, relative to drawing no shadows (0.001: exact)",
    }
}

/// Returns a chart that emphasizes each backend's front; all other points are faint.
pub(super) fn figure(dots: &[Dot], words: &StillWords<'_>) -> Figure {
    let mut figure = Figure::new(&words.title, words.x, words.y).log(true, true);
    figure.subtitle.clone_from(&words.subtitle);
    figure.size = [980.0, 620.0];
    figure
        .references
        .push(Reference::Up(1.0, "no shadow".to_owned()));
    let techniques = distinct(dots, |d| &d.technique);
    let styles = styles_of(&techniques);
    let backends = distinct(dots, |d| &d.backend);
    // Draw the points behind the fronts first, so that all others are on top.
    for (b, backend) in backends.iter().enumerate() {
        for (technique, style) in techniques.iter().zip(&styles) {
            let beaten = points(dots, technique, backend, false);
            figure.series.push(faint(*style, b, beaten));
        }
    }
    // Draw each backend's front, and the points on it.
    for (b, backend) in backends.iter().enumerate() {
        figure.series.push(front_line(dots, backend, b));
        for (technique, style) in techniques.iter().zip(&styles) {
            figure.series.push(Series::points(
                "",
                style.color(b),
                style.marker,
                points(dots, technique, backend, true),
            ));
        }
    }
    // Add the shapes, which are the same on all backends, to the legend.
    for (technique, style) in techniques.iter().zip(&styles) {
        figure.keys.push(Key {
            name: (*technique).to_owned(),
            marker: style.marker,
            color: style.ink().to_owned(),
        });
    }
    figure.notes = notes(dots);
    figure
}

/// Returns a technique's points on one backend, either those on its front or those behind it.
fn points(dots: &[Dot], technique: &str, backend: &str, on_front: bool) -> Vec<Point> {
    let of_technique = dots
        .iter()
        .filter(|d| d.technique == technique && d.backend == backend && d.on_front == on_front);
    of_technique.map(point).collect()
}

/// Returns the series of points behind a front. They are paler rather than transparent, since some
/// viewers don't blend.
fn faint(style: SeriesStyle, backend: usize, points: Vec<Point>) -> Series {
    Series {
        style: Style::Points(style.marker, FAINT_RADIUS, 1.0),
        ..Series::points("", style.faint(backend), style.marker, points)
    }
}

/// Returns the line through the front of a backend, the `b`th one.
fn front_line(dots: &[Dot], backend: &str, b: usize) -> Series {
    let mut front: Vec<[f64; 2]> = dots
        .iter()
        .filter(|d| d.on_front && d.backend == backend)
        .map(|d| d.xy)
        .collect();
    front.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let corners = front
        .iter()
        .map(|xy| Point::at_position(xy[0], xy[1]))
        .collect();
    Series {
        style: Style::Dashed(1.5),
        ..Series::line(format!("Pareto front, {backend}"), color(b), corners)
    }
}

/// Returns a dot as a point; on fronts with the range of its times.
fn point(dot: &Dot) -> Point {
    Point {
        x_range: dot.range.filter(|_| dot.on_front),
        ..Point::at_position(dot.xy[0], dot.xy[1])
    }
}

/// Returns the labels of the points on fronts, at their positions.
fn notes(dots: &[Dot]) -> Vec<Point> {
    let mut out = Vec::new();
    for dot in dots.iter().filter(|d| d.on_front) {
        out.push(Point {
            label: short(dot),
            ..Point::at_position(dot.xy[0], dot.xy[1])
        });
    }
    out
}

/// Returns a short label for a chart: the technique and its first two settings.
fn short(dot: &Dot) -> String {
    let settings: Vec<&str> = dot.settings.split(", ").take(2).collect();
    format!("{} {}", dot.technique, settings.join(", "))
}
