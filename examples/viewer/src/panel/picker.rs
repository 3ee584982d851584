//! A list over the picture from which the keyboard chooses: typing leaves what holds the words, arrows go up and down, Enter takes.

use crate::{
    app::App,
    bookmarks::{self, Bookmark},
    loading::Then,
    render::SIDES,
    settings::entry,
};
use umbrage::{scenes, techniques};

/// What is chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Choice {
    /// A built-in scene, or a file whose path is typed.
    Scene,
    /// A place where a method fails.
    Failure,
    /// The technique of a side.
    Technique(usize),
}

/// The list while it is open.
pub(crate) struct Picker {
    choice: Choice,
    typed: String,
    /// Which of the shown lines Enter takes.
    at: usize,
    /// Whether the line was chosen by arrows, so that it is to be scrolled into view.
    has_moved: bool,
    /// Whether the next letter is that of the key that opened the list.
    skips_letter: bool,
}

/// What came of a key.
pub(crate) enum Outcome {
    /// The list stays open.
    Open,
    Closed,
    Chosen(Taken),
}

/// A line of the list.
struct Line {
    /// What names it in addresses and on the command line.
    name: String,
    /// What the list shows.
    label: String,
    summary: String,
    taken: Taken,
}

/// What was chosen.
#[derive(Clone)]
pub(crate) enum Taken {
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

    fn title(&self) -> String {
        match self.choice {
            Choice::Scene => "Scene, or the path of a .toml, .obj, .glb or .gltf file".to_owned(),
            Choice::Failure => "Place where shadow methods fail".to_owned(),
            Choice::Technique(side) => format!("Technique of the {} side", SIDES[side]),
        }
    }

    /// Returns the lines that hold all words that are typed, in what they show or in their summaries.
    fn lines(&self) -> Vec<Line> {
        let line = |name: &str, summary: &str, taken| Line {
            name: name.to_owned(),
            label: name.to_owned(),
            summary: summary.to_owned(),
            taken,
        };
        let mut lines: Vec<Line> = match self.choice {
            Choice::Scene => scenes::all()
                .iter()
                .map(|e| line(e.name, e.summary, Taken::Scene(e.name.to_owned())))
                .collect(),
            Choice::Failure => bookmarks::all()
                .into_iter()
                .map(|bookmark| Line {
                    name: bookmark.name.to_owned(),
                    label: bookmark.label(),
                    summary: bookmark.description(),
                    taken: Taken::Failure(bookmark),
                })
                .collect(),
            Choice::Technique(side) => techniques::all()
                .iter()
                .map(|e| line(e.name, e.summary, Taken::Technique(side, e.name)))
                .collect(),
        };
        let path = self.typed.trim();
        let typed = path.to_lowercase();
        let holds = |text: &str| {
            let text = text.to_lowercase();
            typed.split_whitespace().all(|word| text.contains(word))
        };
        lines.retain(|line| holds(&format!("{} {}", line.label, line.summary)));
        // What is typed, what begins with it, and what shows it come first; the sort keeps the rest in its order.
        lines.sort_by_key(|line| {
            let is_begun = line.name.starts_with(&typed) || line.label.starts_with(&typed);
            (line.name != typed, !is_begun, !holds(&line.label))
        });
        if self.choice == Choice::Scene && (path.ends_with(".toml") || scenes::is_model(path)) {
            let taken = Taken::Scene(path.to_owned());
            lines.push(line(path, "this file", taken));
        }
        lines
    }
}

impl Picker {
    /// Takes a key or what was typed. Not left to a text field: that would miss what is typed before it is first drawn.
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
                let taken = lines.get(self.at).map(|line| line.taken.clone());
                return taken.map_or(Outcome::Open, Outcome::Chosen);
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

/// Draws the list, if it is open.
pub(crate) fn show(app: &mut App, ui: &egui::Ui) {
    let Some(mut picker) = app.picker.take() else {
        return;
    };
    let mut taken = None;
    let mut is_open = true;
    let middle = super::beside(ui.max_rect(), ui.ctx());
    egui::Window::new(picker.title())
        .id(egui::Id::unique("picker"))
        .open(&mut is_open)
        .resizable(false)
        .collapsible(false)
        .anchor(egui::Align2::CENTER_TOP, [middle, 40.0])
        .show(ui.ctx(), |ui| {
            let window = ui.ctx().viewport_rect().width();
            ui.set_width((window - 32.0).min(430.0));
            taken = contents(&mut picker, ui);
        });
    match taken {
        Some(taken) => take(app, ui.ctx(), taken),
        None if is_open => app.picker = Some(picker),
        None => {}
    }
}

/// Draws what is typed and the lines. Returns what was clicked.
fn contents(picker: &mut Picker, ui: &mut egui::Ui) -> Option<Taken> {
    let mut taken = None;
    egui::Frame::canvas(ui.style()).show(ui, |ui| {
        ui.set_width(ui.available_width());
        if picker.typed.is_empty() {
            ui.weak("type a part of the name or of what it says; Enter takes, Esc leaves");
        } else {
            ui.monospace(format!("{}|", picker.typed));
        }
    });
    let lines = picker.lines();
    egui::ScrollArea::vertical()
        .max_height(300.0)
        .auto_shrink([false, true])
        .show(ui, |ui| {
            for (i, line) in lines.iter().enumerate() {
                let label = ui.selectable_label(i == picker.at, &line.label);
                if i == picker.at && picker.has_moved {
                    label.scroll_to_me(None);
                }
                if label.on_hover_text(&line.summary).clicked() {
                    taken = Some(line.taken.clone());
                }
            }
            if lines.is_empty() {
                ui.weak("nothing has these words");
            }
        });
    picker.has_moved = false;
    if let Some(line) = lines.get(picker.at) {
        ui.weak(&line.summary);
    }
    taken
}

/// Does what was chosen.
pub(crate) fn take(app: &mut App, ctx: &egui::Context, taken: Taken) {
    match taken {
        Taken::Scene(name) => app.open(ctx, &name, Then::Show),
        Taken::Failure(bookmark) => app.open(ctx, bookmark.scene, Then::Compare(bookmark)),
        Taken::Technique(side, name) => {
            app.settings.sides[side].choose(entry(name));
            app.forget_mask(side);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the names of the lines that are left once something is typed.
    fn found(choice: Choice, typed: &str) -> Vec<String> {
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
            let found = found(Choice::Failure, typed);
            assert!(
                found.iter().any(|found| found == name),
                "{typed}: {found:?}"
            );
        }
        assert!(found(Choice::Failure, "nowhere-at-all").is_empty());
    }

    #[test]
    fn scenes_and_techniques_are_found_by_their_summaries_behind_names() {
        assert_eq!(found(Choice::Scene, "fence")[0], "fence");
        // Its summary alone has the word.
        assert!(found(Choice::Scene, "church").contains(&"nave".to_owned()));
        assert_eq!(found(Choice::Technique(0), "pcf")[0], "pcf");
        assert_eq!(found(Choice::Scene, "c3 ro")[0], "c3-room");
        let bricks = found(Choice::Scene, "wall");
        let first_of_summaries = bricks.iter().position(|name| !name.contains("wall"));
        let last_of_names = bricks.iter().rposition(|name| name.contains("wall"));
        assert!(first_of_summaries > last_of_names, "{bricks:?}");
    }
}
