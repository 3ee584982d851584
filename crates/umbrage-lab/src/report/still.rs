//! The charts as figures: still ones as SVG and PNG, for places that cannot run a script, and those of the page.

use super::{
    chart::{Dot, distinct},
    style::{SeriesStyle, color, styles_of},
};
use crate::{
    compare::{CostBasis, Motion, Section},
    output::figure::{Figure, Key, Point, Series, Style},
};

/// Radius of points that the front beats, pixels.
const FAINT_RADIUS: f64 = 3.5;

/// A chart's title and the names of its axes.
pub(super) struct Words<'a> {
    pub(super) title: String,
    pub(super) subtitle: String,
    pub(super) x: &'a str,
    pub(super) y: &'a str,
}

/// Where a chart is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Medium {
    /// On white, alone: the points on fronts have their names beside them.
    Still,
    /// In the page, whose script shows what a point is: each point's title is its place among the dots.
    Page,
}

/// Returns the words of one scene's chart; the page gives it a title.
pub(super) fn of_scene(clock: CostBasis, motion: Motion) -> Words<'static> {
    let x = match (clock, motion) {
        (CostBasis::Wall, Motion::Still) => "time of a frame while nothing moves, ms",
        (CostBasis::Wall, Motion::CameraMoves) => "time of a frame while the camera moves, ms",
        (CostBasis::Wall, Motion::AllMoves) => "time of a frame while all moves, ms",
        (CostBasis::Cost, _) => "counted cost of a frame, ms by the price list",
    };
    Words {
        title: String::new(),
        subtitle: String::new(),
        x,
        y: "RMSE of visibility (1e-4 and less)",
    }
}

/// What a chart over many scenes is about.
pub(super) struct GroupWords<'a> {
    pub(super) scenes: usize,
    /// `hard` or `soft`.
    pub(super) light: &'a str,
    pub(super) section: Section,
    pub(super) motion: Motion,
    pub(super) backend: &'a str,
    pub(super) clock: CostBasis,
}

/// Returns the words of a chart over many scenes.
pub(super) fn of_group(group: &GroupWords<'_>) -> Words<'static> {
    let x = match group.clock {
        CostBasis::Wall => "time of a frame, relative to hard shadows from a map of middle size",
        CostBasis::Cost => {
            "counted cost of a frame, relative to hard shadows from a map of middle size"
        }
    };
    let kind = match group.section {
        Section::Content => "scenes of real size",
        Section::Check => "small scenes",
    };
    let motion = group.motion.words();
    Words {
        title: format!(
            "Speed against accuracy of {} shadows on {}",
            group.light, group.backend
        ),
        subtitle: format!(
            "means over {} {kind}, {motion}; down and left is better",
            group.scenes
        ),
        x,
        y: "error, relative to drawing no shadows",
    }
}

/// Returns a chart in which each backend's front stands out and everything else is faint.
pub(super) fn figure(dots: &[Dot], words: &Words<'_>, medium: Medium) -> Figure {
    let mut figure = Figure::new(&words.title, words.x, words.y).log(true, true);
    figure.subtitle.clone_from(&words.subtitle);
    figure.size = [980.0, 620.0];
    let techniques = distinct(dots, |d| &d.technique);
    let styles = styles_of(&techniques);
    let backends = distinct(dots, |d| &d.backend);
    // Points that a front beats are drawn first, so that all others lie above them.
    for (b, backend) in backends.iter().enumerate() {
        for (technique, style) in techniques.iter().zip(&styles) {
            let beaten = points(dots, technique, backend, false, medium);
            figure.series.push(faint(*style, b, beaten, medium));
        }
    }
    for (b, backend) in backends.iter().enumerate() {
        figure.series.push(front_line(dots, backend, b));
        for (technique, style) in techniques.iter().zip(&styles) {
            figure.series.push(Series::points(
                "",
                style.color(b),
                style.marker,
                points(dots, technique, backend, true, medium),
            ));
        }
    }
    let ink = match medium {
        Medium::Still => SeriesStyle::ink,
        Medium::Page => SeriesStyle::page_ink,
    };
    // The legend explains the shapes, which are the same on all backends.
    for (technique, style) in techniques.iter().zip(&styles) {
        figure.keys.push(Key {
            name: (*technique).to_owned(),
            marker: style.marker,
            color: ink(*style).to_owned(),
        });
    }
    if medium == Medium::Still {
        figure.notes = notes(dots);
    }
    figure
}

/// Returns a technique's points on one backend, those on its front or those beaten by it.
fn points(
    dots: &[Dot],
    technique: &str,
    backend: &str,
    on_front: bool,
    medium: Medium,
) -> Vec<Point> {
    let mut out = Vec::new();
    for (place, dot) in dots.iter().enumerate() {
        if dot.technique != technique || dot.backend != backend || dot.on_front != on_front {
            continue;
        }
        let title = match medium {
            Medium::Still => String::new(),
            Medium::Page => place.to_string(),
        };
        out.push(Point {
            title,
            ..point(dot)
        });
    }
    out
}

/// Returns the series of points that a front beats. On white they are paler rather than transparent, since not every viewer
/// blends; the page, which may be dark, makes them transparent itself.
fn faint(style: SeriesStyle, backend: usize, points: Vec<Point>, medium: Medium) -> Series {
    let color = match medium {
        Medium::Still => style.faint(backend),
        Medium::Page => style.color(backend),
    };
    Series {
        style: Style::Points(style.marker, FAINT_RADIUS, 1.0),
        ..Series::points("", color, style.marker, points)
    }
}

/// Returns the line through the points of a backend's front, the `b`th backend.
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

/// Returns a dot as a point; on fronts with the range of its times.
fn point(dot: &Dot) -> Point {
    Point {
        x_range: dot.range.filter(|_| dot.on_front),
        ..Point::at(dot.xy[0], dot.xy[1])
    }
}

/// Returns the names of the points on fronts, at their places.
fn notes(dots: &[Dot]) -> Vec<Point> {
    let mut out = Vec::new();
    for dot in dots.iter().filter(|d| d.on_front) {
        out.push(Point {
            label: short(dot),
            ..Point::at(dot.xy[0], dot.xy[1])
        });
    }
    out
}

/// Returns a label that is short enough for a chart: the technique and its first two settings.
fn short(dot: &Dot) -> String {
    let settings: Vec<&str> = dot.settings.split(", ").take(2).collect();
    format!("{} {}", dot.technique, settings.join(", "))
}
