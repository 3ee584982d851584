//! A list for choosing with the keyboard: typing keeps the lines with these words, arrows move,
//! Enter chooses.

use crate::{
    bookmarks::{self, Bookmark},
    side::SIDES,
};
use umbrage::{scenes, techniques};

/// Kinds of lists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Choice {
    /// Built-in scenes, and a file whose path is typed.
    Scene,
    /// Failures of shadow methods.
    Failure,
    /// Techniques of a side.
    Technique(usize),
}

/// The open list.
pub(crate) struct Picker {
    choice: Choice,
    pub typed: String,
    /// Index of the line that Enter chooses.
    pub at: usize,
    /// `true` if arrows moved to the line, which must then be scrolled into view.
    pub has_moved: bool,
    /// `true` to skip the next letter, which is that of the key that opened the list.
    skips_letter: bool,
}

/// Effect of a key.
pub(crate) enum Outcome {
    /// The list stays open.
    Open,
    Closed,
    Chosen(Chosen),
}

/// A line of the list.
pub(crate) struct Line {
    /// The name in addresses and on the command line.
    name: String,
    pub label: String,
    pub summary: String,
    pub chosen: Chosen,
}

/// A choice.
#[derive(Clone)]
pub(crate) enum Chosen {
    Scene(String),
    Failure(Bookmark),
    Technique(usize, &'static str),
}

impl Picker {
    pub(crate) const fn new(choice: Choice) -> Self {
        Self {
            choice,
            typed: String::new(),
            at: 0,
            has_moved: false,
            skips_letter: true,
        }
    }

    pub(crate) fn title(&self) -> String {
        match self.choice {
            Choice::Scene => "Scene, or the path of a .toml, .obj, .glb or .gltf file".to_owned(),
            Choice::Failure => "Failure of shadow methods".to_owned(),
            Choice::Technique(side) => format!("Technique of the {} side", SIDES[side]),
        }
    }

    /// Returns the lines whose labels or summaries contain all typed words.
    pub(crate) fn lines(&self) -> Vec<Line> {
        let line = |name: &str, summary: &str, chosen| Line {
            name: name.to_owned(),
            label: name.to_owned(),
            summary: summary.to_owned(),
            chosen,
        };
        let mut lines: Vec<Line> = match self.choice {
            Choice::Scene => scenes::all()
                .iter()
                .map(|e| line(e.name, e.summary, Chosen::Scene(e.name.to_owned())))
                .collect(),
            Choice::Failure => bookmarks::all()
                .into_iter()
                .map(|bookmark| Line {
                    label: bookmark.label(),
                    ..line(
                        bookmark.name,
                        &bookmark.description(),
                        Chosen::Failure(bookmark),
                    )
                })
                .collect(),
            Choice::Technique(side) => techniques::all()
                .iter()
                .map(|e| line(e.name, e.summary, Chosen::Technique(side, e.name)))
                .collect(),
        };
        let path = self.typed.trim();
        let typed = path.to_lowercase();
        let holds = |text: &str| {
            let text = text.to_lowercase();
            typed.split_whitespace().all(|word| text.contains(word))
        };
        lines.retain(|line| holds(&format!("{} {}", line.label, line.summary)));
        // Sort the typed name, names that start with it, and labels with the words first. The sort
        // is stable.
        lines.sort_by_key(|line| {
            let is_begun = line.name.starts_with(&typed) || line.label.starts_with(&typed);
            (line.name != typed, !is_begun, !holds(&line.label))
        });
        if self.choice == Choice::Scene && (path.ends_with(".toml") || scenes::is_model(path)) {
            let chosen = Chosen::Scene(path.to_owned());
            lines.push(line(path, "this file", chosen));
        }
        lines
    }
}

impl Picker {
    /// Handles a key or a text. A text field would miss input before it is first drawn.
    pub(crate) fn take_event(&mut self, event: &egui::Event) -> Outcome {
        let typed = self.typed.len();
        match event {
            egui::Event::Text(_) if self.skips_letter => self.skips_letter = false,
            egui::Event::Text(text) | egui::Event::Paste(text) => self.typed += text,
            egui::Event::Key {
                key, pressed: true, ..
            } => return self.take_key(*key),
            egui::Event::Key { .. } => self.skips_letter = false,
            _ => {}
        }
        if self.typed.len() != typed {
            self.at = 0;
        }
        Outcome::Open
    }

    fn take_key(&mut self, key: egui::Key) -> Outcome {
        self.skips_letter = false;
        let lines = self.lines();
        let to = match key {
            egui::Key::Escape => return Outcome::Closed,
            egui::Key::Enter => {
                let chosen = lines.get(self.at).map(|line| line.chosen.clone());
                return chosen.map_or(Outcome::Open, Outcome::Chosen);
            }
            egui::Key::Backspace => {
                self.typed.pop();
                0
            }
            egui::Key::ArrowUp => self.at.saturating_sub(1),
            egui::Key::ArrowDown => self.at + 1,
            egui::Key::PageUp => self.at.saturating_sub(10),
            egui::Key::PageDown => self.at + 10,
            _ => return Outcome::Open,
        };
        self.has_moved = true;
        self.at = to.min(self.lines().len().saturating_sub(1));
        Outcome::Open
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the names of the remaining lines for a typed text.
    fn found_names(choice: Choice, typed: &str) -> Vec<String> {
        let picker = Picker {
            typed: typed.to_owned(),
            ..Picker::new(choice)
        };
        picker.lines().into_iter().map(|line| line.name).collect()
    }

    #[test]
    fn faults_are_found_by_the_words_that_people_have() {
        for (typed, name) in [
            ("acne", "low-sun-5"),
            ("Acne spheres", "low-sun-5"),
            ("peter-panning", "thin-plate"),
            ("detached", "thin-plate"),
            ("leaking", "sealed-room"),
            ("bleeding", "two-plates"),
            ("flicker", "hills-yaw"),
            ("jagged", "fence"),
            ("missing", "tower-out-of-view"),
            ("penumbra", "two-blockers"),
        ] {
            let found = found_names(Choice::Failure, typed);
            assert!(
                found.iter().any(|found| found == name),
                "{typed}: {found:?}"
            );
        }
        assert!(found_names(Choice::Failure, "nowhere-at-all").is_empty());
    }

    #[test]
    fn scenes_and_techniques_are_found_by_their_summaries_behind_names() {
        assert_eq!(found_names(Choice::Scene, "fence")[0], "fence");
        // Only its summary has the word.
        assert!(found_names(Choice::Scene, "church").contains(&"nave".to_owned()));
        assert_eq!(found_names(Choice::Technique(0), "pcf")[0], "pcf");
        assert_eq!(found_names(Choice::Scene, "c3 ro")[0], "c3-room");
        let bricks = found_names(Choice::Scene, "wall");
        let first_of_summaries = bricks.iter().position(|name| !name.contains("wall"));
        let last_of_names = bricks.iter().rposition(|name| name.contains("wall"));
        assert!(first_of_summaries > last_of_names, "{bricks:?}");
    }
}
