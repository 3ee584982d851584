//! Points of the still charts: the settings of a group, error against time.

use crate::compare::{CostBasis, MIN_ERROR, Relative, SettingGroup};

/// A point of a chart: a setting.
#[derive(Clone, Debug)]
pub(super) struct Dot {
    pub(super) technique: String,
    pub(super) backend: String,
    pub(super) settings: String,
    pub(super) xy: [f64; 2],
    /// Fastest and slowest run.
    pub(super) range: Option<[f64; 2]>,
    pub(super) on_front: bool,
}

/// Returns a group's settings by one clock. Omits settings without a time by that clock, and
/// `none`, which takes no time.
pub(super) fn dots(group: &SettingGroup, clock: CostBasis) -> Vec<Dot> {
    let front = group.front(clock);
    let mut out = Vec::new();
    for (place, setting) in group.settings.iter().enumerate() {
        if setting.technique == "none" {
            continue;
        }
        if let Some(dot) = dot(setting, clock) {
            let on_front = front.contains(&place);
            out.push(Dot { on_front, ..dot });
        }
    }
    out
}

/// Returns a setting as a dot that is on no front; `None` if it has no time.
fn dot(setting: &Relative, clock: CostBasis) -> Option<Dot> {
    let x = setting.take(clock)?;
    let range = match (clock, setting.time) {
        (CostBasis::Wall, Some(time)) => Some([time.min, time.max]),
        _ => None,
    };
    Some(Dot {
        technique: setting.technique.clone(),
        backend: setting.backend.clone(),
        settings: setting.settings.clone(),
        xy: [x, setting.error.max(MIN_ERROR)],
        range,
        on_front: false,
    })
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
