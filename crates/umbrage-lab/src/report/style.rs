//! Style of each technique in charts: a shape, and a tone of its backend's color. It is the same on
//! the page and in still charts.

use crate::output::figure::Marker;

/// Style that distinguishes a technique from all others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct SeriesStyle {
    pub(super) marker: Marker,
    /// Index of the tone of a colour, below [`TONES`].
    tone: usize,
}

/// Number of tones of each colour. With ten shapes they make styles for twenty techniques.
const TONES: usize = 2;

/// Number of distinct styles.
const STYLES: usize = TONES * Marker::ALL.len();

/// All tones of a colour.
type Tones = [&'static str; TONES];

/// Colours of backends, readable on light and dark: blue and orange; further backends are grey.
const COLORS: [Tones; 3] = [
    ["#3b82e0", "#1e4fa8"],
    ["#ea7317", "#a13f00"],
    ["#8a94a3", "#5b6472"],
];

/// Backends' colours for points behind the front. They are paler rather than transparent, since
/// some viewers don't blend.
const FAINT: [Tones; 3] = [
    ["#c5daf6", "#a3b8da"],
    ["#fad5b9", "#dfb395"],
    ["#dcdfe4", "#c3c8d0"],
];

/// Colours of legends, independent of backends.
const INK: Tones = ["#7d8796", "#2b3340"];

impl SeriesStyle {
    /// Returns the style of the technique at an index. From [`STYLES`] on, styles repeat.
    fn nth(place: usize) -> Self {
        let style = place % STYLES;
        let shapes = Marker::ALL.len();
        Self {
            marker: Marker::ALL[style % shapes],
            tone: style / shapes,
        }
    }

    /// Returns the color on a backend.
    pub(super) fn color(self, backend: usize) -> &'static str {
        COLORS[backend.min(COLORS.len() - 1)][self.tone]
    }

    /// Returns the pale color on a backend, for points behind the front.
    pub(super) fn faint(self, backend: usize) -> &'static str {
        FAINT[backend.min(FAINT.len() - 1)][self.tone]
    }

    /// Returns the color in the legend of a still chart.
    pub(super) fn ink(self) -> &'static str {
        INK[self.tone]
    }
}

/// Returns the main color of a backend.
pub(super) fn color(backend: usize) -> &'static str {
    SeriesStyle::nth(0).color(backend)
}

/// Returns the styles of a chart's techniques. Those of the registry have the style of their index
/// in it, so that they look the same in every chart. Others follow after them.
pub(super) fn styles_of(techniques: &[&str]) -> Vec<SeriesStyle> {
    let all = umbrage_techniques::all();
    let mut next = all.len();
    let mut styles = Vec::with_capacity(techniques.len());
    for name in techniques {
        let listed = all.iter().position(|entry| entry.name == *name);
        styles.push(SeriesStyle::nth(listed.unwrap_or(next)));
        if listed.is_none() {
            next += 1;
        }
    }
    styles
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    /// With one technique too many, two would look alike: then add a tone to [`COLORS`].
    #[test]
    fn every_technique_of_the_registry_has_a_look_of_its_own() {
        let names: Vec<&str> = umbrage_techniques::all().iter().map(|e| e.name).collect();
        assert!(
            names.len() < STYLES,
            "{} techniques, {STYLES} styles, one of them for a user's own",
            names.len()
        );
        let drawn = |style: &SeriesStyle| {
            (
                style.marker,
                [0, 1, 2].map(|b| [style.color(b), style.faint(b)]),
                style.ink(),
            )
        };
        let all: HashSet<_> = styles_of(&names).iter().map(drawn).collect();
        assert_eq!(all.len(), names.len());
        // A collision would be detected.
        assert_eq!(SeriesStyle::nth(3), SeriesStyle::nth(3 + STYLES));
    }

    #[test]
    fn looks_do_not_depend_on_what_else_is_drawn() {
        let names: Vec<&str> = umbrage_techniques::all().iter().map(|e| e.name).collect();
        let all = styles_of(&names);
        assert_eq!(
            styles_of(&[names[5], "mine", names[2], "yours"])[..3],
            [all[5], SeriesStyle::nth(names.len()), all[2]]
        );
        let [mine, yours] = styles_of(&["mine", "yours"])[..] else {
            panic!("two")
        };
        assert!(mine != yours && !all.contains(&mine) && !all.contains(&yours));
    }

    /// No two backends share a colour, in any tone.
    #[test]
    fn backends_are_distinguished_by_colour() {
        let colors: HashSet<&str> = COLORS.iter().chain(&FAINT).flatten().copied().collect();
        assert_eq!(colors.len(), 2 * COLORS.len() * TONES);
    }
}
