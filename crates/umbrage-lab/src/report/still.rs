//! The charts as SVG and PNG, for pages that cannot run a script.

use super::chart::{Dot, color, distinct};
use crate::{
    compare::Clock,
    figure::{Figure, Marker, Point, Series, Style},
};

/// Opacity and radius of points that the front beats: seen, but not looked at.
const FAINT: (f64, f64) = (0.22, 4.0);

/// What the axes say.
pub(super) struct Words<'a> {
    pub(super) title: &'a str,
    pub(super) subtitle: String,
    pub(super) x: &'a str,
    pub(super) y: &'a str,
}

/// Words for all scenes.
pub(super) fn of_all(scenes: usize, clock: Clock) -> Words<'static> {
    let x = match clock {
        Clock::Wall => "time, relative to hard shadows from a map of middle size",
        Clock::Cost => "counted cost, relative to hard shadows from a map of middle size",
    };
    Words {
        title: "Speed against accuracy of every shadow technique",
        subtitle: format!("geometric means over {scenes} scenes; down and left is better"),
        x,
        y: "error, relative to drawing no shadows",
    }
}

/// A backend's front with its names, everything else faint: blue and orange as in the page.
pub(super) fn figure(dots: &[Dot], words: &Words<'_>) -> Figure {
    let mut figure = Figure::new(words.title, words.x, words.y).log(true, true);
    figure.subtitle.clone_from(&words.subtitle);
    figure.size = [980.0, 620.0];
    let techniques = distinct(dots, |d| &d.technique);
    for (b, backend) in distinct(dots, |d| &d.backend).into_iter().enumerate() {
        let of_backend: Vec<&Dot> = dots.iter().filter(|d| d.backend == backend).collect();
        let mut front: Vec<&Dot> = of_backend.iter().filter(|d| d.on_front).copied().collect();
        front.sort_by(|a, b| a.xy[0].total_cmp(&b.xy[0]));
        let corners = front.iter().map(|d| Point::at(d.xy[0], d.xy[1])).collect();
        let line = Series { style: Style::Dashed(1.5), ..Series::line(format!("front, {backend}"), color(b), corners) };
        figure.series.push(line);
        for (t, technique) in techniques.iter().enumerate() {
            let of = |on_front: bool| {
                let mine = of_backend.iter().filter(move |d| d.technique == *technique && d.on_front == on_front);
                mine.map(|d| point(d)).collect::<Vec<_>>()
            };
            let marker = Marker::ALL[t % Marker::ALL.len()];
            let (opacity, radius) = FAINT;
            // One backend's shapes explain the other's.
            let name = if b == 0 { (*technique).to_owned() } else { String::new() };
            let faint = Style::Points(marker, radius, opacity);
            figure.series.push(Series { style: faint, ..Series::points("", color(b), marker, of(false)) });
            let bright = of(true);
            if bright.is_empty() && !name.is_empty() {
                // A shape that is only ever beaten must be in the legend, too: drawn again where its first point is.
                let first = of(false).into_iter().take(1).collect();
                figure.series.push(Series { style: faint, ..Series::points(name, color(b), marker, first) });
            } else {
                figure.series.push(Series::points(name, color(b), marker, bright));
            }
        }
    }
    figure
}

fn point(dot: &Dot) -> Point {
    let label = if dot.on_front { short(dot) } else { String::new() };
    let x_range = dot.range.filter(|_| dot.on_front);
    Point { x_range, label, ..Point::at(dot.xy[0], dot.xy[1]) }
}

/// A label short enough to stand in a chart: the technique and its first setting but one.
fn short(dot: &Dot) -> String {
    let settings: Vec<&str> = dot.settings.split(", ").take(2).collect();
    format!("{} {}", dot.technique, settings.join(" "))
}
