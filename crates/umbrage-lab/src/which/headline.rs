//! Chart for the first page of the documentation: error against time of at most ten settings.

use super::{
    cells::words_of,
    groups::{Answer, LIGHTS, OfBackend, WhichGroup},
};
use crate::{
    compare::{MIN_ERROR, Relative, SceneResult, Section, SettingGroup, relative},
    output::figure::{COLORS, Figure, Marker, Point, Series, Style},
};

/// Greatest number of points: more labels would overlap at the width of a page.
const POINTS: usize = 10;

/// Returns the chart of scenes under a sun without extent, of all sizes. Times are a card's if
/// there is one, else the first backend's. `None` without such scenes.
pub(super) fn chart(groups: &[WhichGroup]) -> Option<Figure> {
    let suns = groups
        .iter()
        .filter(|g| g.is_ideal && LIGHTS[g.light].0 == "directional");
    let suns: Vec<&OfBackend> = suns.filter_map(|group| group.backends.first()).collect();
    // A card comes first. Other groups may not have been timed on it.
    let backend = suns.iter().find(|of| of.is_card()).or(suns.first())?;
    let of_backend = suns.iter().filter(|of| of.backend == backend.backend);
    let scenes: Vec<&SceneResult> = of_backend.flat_map(|of| &of.scenes).collect();
    let mut settings = relative(&scenes);
    settings.retain(|setting| setting.backend == backend.backend);
    let group = SettingGroup {
        light: "hard",
        section: Section::Content,
        motion: scenes.first()?.motion,
        scenes: Vec::new(),
        backend: backend.backend.clone(),
        error_of_none: 1.0,
        settings,
    };
    Some(figure(&group, &scenes, backend.is_card()))
}

/// Returns the chart of a group's settings.
fn figure(group: &SettingGroup, scenes: &[&SceneResult], is_card: bool) -> Figure {
    let clock = group.clock();
    let front = group.front(clock);
    let others = others_by_distance(group, &front);
    let front: Vec<usize> = front.into_iter().take(POINTS).collect();
    let others = others.into_iter().take(POINTS - front.len());
    let point = |place: usize| {
        let setting = &group.settings[place];
        Some(Point::at_position(
            setting.take(clock)?,
            100.0 * setting.error,
        ))
    };
    let mut figure = Figure::new(
        format!("Error and time of shadows on {}", group.backend),
        "time of a frame's shadows, relative to one 2048 map with one comparison",
        "error relative to no shadows, %",
    )
    .with(Series {
        style: Style::Dashed(1.5),
        ..Series::line(
            "",
            COLORS[0],
            front.iter().copied().filter_map(point).collect(),
        )
    });
    // Name each setting in the legend: labels at the points would overlap.
    let colored = front.iter().map(|&place| (place, COLORS[0]));
    let colored = colored.chain(others.map(|place| (place, COLORS[6])));
    for ((place, color), marker) in colored.zip(Marker::ALL) {
        let Some(point) = point(place) else {
            continue;
        };
        let name = format!(
            "{}: {}, {:.1}x",
            label(&group.settings[place]),
            percent(point.y),
            point.x
        );
        figure = figure.with(Series::points(name, color, marker, vec![point]));
    }
    let names: Vec<&str> = scenes.iter().map(|scene| scene.name.as_str()).collect();
    let hardware = if is_card {
        ""
    } else {
        "; not yet measured on hardware"
    };
    figure.subtitle = format!(
        "means over {}; down and left is better{hardware}",
        names.join(", ")
    );
    figure.size = [800.0, 400.0];
    figure
}

/// Returns the best setting of each technique that is not on the front, closest to the front first.
fn others_by_distance(group: &SettingGroup, front: &[usize]) -> Vec<usize> {
    let clock = group.clock();
    let position = |place: usize| {
        let setting = &group.settings[place];
        let time = setting.take(clock)?;
        Some([time.ln(), setting.error.max(MIN_ERROR).ln()])
    };
    // Least distance by which a setting must move, on logarithmic axes, to reach the front.
    let distance = |place: usize| {
        let own = position(place)?;
        let to = |&other: &usize| {
            let front = position(other)?;
            Some((own[0] - front[0]).max(own[1] - front[1]))
        };
        front.iter().filter_map(to).reduce(f64::min)
    };
    let name = |place: usize| &group.settings[place].technique;
    let mut best: Vec<(f64, usize)> = Vec::new();
    for place in 0..group.settings.len() {
        let is_on_front = front.iter().any(|&other| name(other) == name(place));
        if is_on_front || name(place) == "none" {
            continue;
        }
        let Some(distance) = distance(place) else {
            continue;
        };
        match best
            .iter_mut()
            .find(|(_, other)| name(*other) == name(place))
        {
            Some(known) if distance < known.0 => *known = (distance, place),
            Some(_) => {}
            None => best.push((distance, place)),
        }
    }
    best.sort_by(|a, b| a.0.total_cmp(&b.0));
    best.into_iter().map(|(_, place)| place).collect()
}

/// Returns an error in percent, as the legend shows it.
fn percent(error: f64) -> String {
    if error == 0.0 {
        "exact".to_owned()
    } else {
        format!("{error:.0} %")
    }
}

/// Returns a short label: the technique, its first setting, and its cascades.
fn label(setting: &Relative) -> String {
    let words = words_of(&Answer::from_setting(setting));
    let mut parts = words.split(", ");
    let first = parts.next().unwrap_or_default().to_owned();
    let cascades = parts.find(|part| part.contains("cascades"));
    let cascades = cascades.and_then(|part| part.split(" log").next());
    let cascades = cascades.map_or_else(String::new, |part| format!(", {part}"));
    format!("{} {first}{cascades}", setting.technique)
}
