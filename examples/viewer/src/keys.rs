//! The keys: one list of what they do, which is also what F1 shows.

use crate::{
    app::App,
    bookmarks,
    camera::{Mode, ViewCamera},
    lights::{EditLight, MAX_LIGHTS},
    loading::Then,
    measure::figures::Picture,
    panel::{
        self,
        picker::{self, Choice, Outcome, Picker},
    },
};
use egui::{Key, Modifiers};
use umbrage::glam::{Quat, Vec2, Vec3};
use web_time::Duration;

/// What a key does.
#[derive(Clone, Copy)]
enum Action {
    Help,
    Choose(Choice),
    /// The next place of failure, or the one before.
    Failure(isize),
    Play,
    Split,
    Flip,
    /// Moves the divider by steps.
    Divide(f32),
    Error,
    /// The next picture over the scene, or the one before.
    Picture(isize),
    /// The next light, or the one before.
    Light(isize),
    AddLight,
    RemoveLight,
    LightOn,
    /// Moves or turns the chosen light by steps: to the right, up, and away from the eye.
    MoveLight(Vec3),
    Turns,
    Plan,
    ShowPlan,
    /// Copies a side's preset: the shown one's or the left's, or the other one's.
    Copy(usize),
    Maps,
    /// Folds the panel, or unfolds it.
    Fold,
    Home,
    Orbit,
    /// Goes ahead by steps of the wheel, or nearer in orbit mode.
    Near(f32),
    Screenshot,
    /// Makes text larger or smaller.
    Zoom(f32),
    AutomaticZoom,
    Quit,
    Leave,
}

/// What is held beside the key.
#[derive(Clone, Copy)]
enum With {
    Nothing,
    Shift,
    /// Shift or not.
    Any,
    /// Ctrl, or the command key of a Mac.
    Command,
}

type Bound = (With, Key, Action);

/// A line of the help: keys, what they do, and how that is done. What is not done here (the mouse, keys that are held) has no actions.
pub(crate) struct Keys {
    pub keys: &'static str,
    pub what: &'static str,
    actions: &'static [Bound],
}

const fn line(keys: &'static str, what: &'static str, actions: &'static [Bound]) -> Keys {
    Keys {
        keys,
        what,
        actions,
    }
}

/// A step of the divider, as a share of the width.
const DIVIDER_STEP: f32 = 0.02;
/// A step of a light that is moved, as a share of what is seen across.
const LIGHT_STEP: f32 = 0.04;
/// A step of a light that is turned, radians: two degrees.
const LIGHT_TURN: f32 = 0.035;
/// Shift makes lights' steps so much finer.
const FINE: f32 = 0.1;
/// What keys turn the view by in a second, in points of the mouse.
const LOOK: f32 = 350.0;

#[cfg(not(target_arch = "wasm32"))]
const SCREENSHOT: &str = "saves a screenshot";
/// There are no folders to save it in, and the key is the browser's.
#[cfg(target_arch = "wasm32")]
const SCREENSHOT: &str = "screenshots are the browser's own";

pub(crate) const KEYS: [Keys; 36] = {
    use With::{Any, Command, Nothing, Shift};
    [
        line("W A S D, E Q", "fly; with shift faster", &[]),
        line("J L, I K", "look around, or go around", &[]),
        line("right mouse button", "looks around, or goes around", &[]),
        line("middle button, wheel", "sideways; ahead and back", &[]),
        line("O", "fly or orbit", &[(Nothing, Key::O, Action::Orbit)]),
        line(
            "plus, minus",
            "ahead and back; nearer and farther in orbit",
            &[
                (Any, Key::Plus, Action::Near(1.0)),
                (Any, Key::Equals, Action::Near(1.0)),
                (Any, Key::Minus, Action::Near(-1.0)),
            ],
        ),
        line(
            "Home",
            "back to the scene's own view",
            &[(Nothing, Key::Home, Action::Home)],
        ),
        line(
            "F2",
            "chooses a scene or a file",
            &[(Nothing, Key::F2, Action::Choose(Choice::Scene))],
        ),
        line(
            "F3",
            "chooses a place of failure",
            &[(Nothing, Key::F3, Action::Choose(Choice::Failure))],
        ),
        line(
            "B, Shift B",
            "next place of failure, or the one before",
            &[
                (Nothing, Key::B, Action::Failure(1)),
                (Shift, Key::B, Action::Failure(-1)),
            ],
        ),
        line(
            "Space",
            "plays what moves there, or pauses",
            &[(Nothing, Key::Space, Action::Play)],
        ),
        line(
            "1, 2",
            "choose the technique of the left, of the right",
            &[
                (Nothing, Key::Num1, Action::Choose(Choice::Technique(0))),
                (Nothing, Key::Num2, Action::Choose(Choice::Technique(1))),
            ],
        ),
        line(
            "X",
            "both sides, or one",
            &[(Nothing, Key::X, Action::Split)],
        ),
        line(
            "F",
            "flips between the sides",
            &[(Nothing, Key::F, Action::Flip)],
        ),
        line(
            "comma, period",
            "move the divider",
            &[
                (Nothing, Key::Comma, Action::Divide(-1.0)),
                (Nothing, Key::Period, Action::Divide(1.0)),
            ],
        ),
        line(
            "H",
            "errors as a picture",
            &[(Nothing, Key::H, Action::Error)],
        ),
        line(
            "V, Shift V",
            "next picture over the scene, or the one before",
            &[
                (Nothing, Key::V, Action::Picture(1)),
                (Shift, Key::V, Action::Picture(-1)),
            ],
        ),
        line("click on a light", "chooses it; its handles move it", &[]),
        line(
            "N, Shift N",
            "next light, or the one before",
            &[
                (Nothing, Key::N, Action::Light(1)),
                (Shift, Key::N, Action::Light(-1)),
            ],
        ),
        line(
            "arrows, Page Up, Down",
            "move or turn the light; with shift finely",
            &[
                (Any, Key::ArrowLeft, Action::MoveLight(Vec3::NEG_X)),
                (Any, Key::ArrowRight, Action::MoveLight(Vec3::X)),
                (Any, Key::ArrowDown, Action::MoveLight(Vec3::NEG_Z)),
                (Any, Key::ArrowUp, Action::MoveLight(Vec3::Z)),
                (Any, Key::PageDown, Action::MoveLight(Vec3::NEG_Y)),
                (Any, Key::PageUp, Action::MoveLight(Vec3::Y)),
            ],
        ),
        line(
            "R",
            "handles and arrows turn the light, or move it",
            &[(Nothing, Key::R, Action::Turns)],
        ),
        line(
            "G",
            "the light on or off",
            &[(Nothing, Key::G, Action::LightOn)],
        ),
        line(
            "Insert, Delete",
            "add a light, remove the chosen one",
            &[
                (Nothing, Key::Insert, Action::AddLight),
                (Nothing, Key::Delete, Action::RemoveLight),
            ],
        ),
        line(
            "P",
            "finds the least for this view, or cancels that",
            &[(Nothing, Key::P, Action::Plan)],
        ),
        line(
            "Shift P",
            "shows what was found on the left",
            &[(Shift, Key::P, Action::ShowPlan)],
        ),
        line(
            "C, Shift C",
            "copies the shown (or left) preset, the other",
            &[
                (Nothing, Key::C, Action::Copy(0)),
                (Shift, Key::C, Action::Copy(1)),
            ],
        ),
        line(
            "F4",
            "folds the panel, or unfolds it",
            &[(Nothing, Key::F4, Action::Fold)],
        ),
        line("M", "the maps", &[(Nothing, Key::M, Action::Maps)]),
        line("Tab, Shift Tab", "through the panel; Enter presses", &[]),
        line(
            "arrows in the panel",
            "to the neighbours; sliders change",
            &[],
        ),
        line(
            "Esc",
            "leaves the panel, closes, cancels loading",
            &[(Any, Key::Escape, Action::Leave)],
        ),
        line(
            "Ctrl plus, minus",
            "larger and smaller text",
            &[
                (Command, Key::Plus, Action::Zoom(0.1)),
                (Command, Key::Equals, Action::Zoom(0.1)),
                (Command, Key::Minus, Action::Zoom(-0.1)),
            ],
        ),
        line(
            "Ctrl 0",
            "text as large as goes with the window",
            &[(Command, Key::Num0, Action::AutomaticZoom)],
        ),
        line(
            "F12",
            SCREENSHOT,
            &[(Nothing, Key::F12, Action::Screenshot)],
        ),
        line("F1", "these keys", &[(Nothing, Key::F1, Action::Help)]),
        line(
            "Ctrl Q",
            "ends the program",
            &[(Command, Key::Q, Action::Quit)],
        ),
    ]
};

impl With {
    const fn is_held(self, modifiers: Modifiers) -> bool {
        let is_plain = !modifiers.command && !modifiers.ctrl && !modifiers.alt;
        match self {
            Self::Nothing => is_plain && !modifiers.shift,
            Self::Shift => is_plain && modifiers.shift,
            Self::Any => is_plain,
            // Plus is typed with shift on many keyboards.
            Self::Command => modifiers.command,
        }
    }
}

/// Returns what a key that was pressed does, and whether shift was held.
fn action_of(ctx: &egui::Context, event: &egui::Event) -> Option<(Action, bool)> {
    let egui::Event::Key {
        key,
        pressed: true,
        modifiers,
        ..
    } = event
    else {
        return None;
    };
    let mut bound = KEYS.iter().flat_map(|keys| keys.actions);
    let (with, _, action) = bound.find(|(with, of, _)| of == key && with.is_held(*modifiers))?;
    // The panel's own arrows go from one part to the next, and its space presses.
    let is_in_panel = ctx.memory(|memory| memory.focused().is_some());
    let is_left_to_panel = match with {
        With::Command => false,
        _ => {
            let is_of_panel = matches!(action, Action::MoveLight(_) | Action::Play);
            ctx.text_edit_focused() || (is_in_panel && is_of_panel)
        }
    };
    (!is_left_to_panel).then_some((*action, modifiers.shift))
}

/// Returns the next of `count`, or the one before, round and round.
fn stepped(at: usize, by: isize, count: usize) -> usize {
    (at as isize + by).rem_euclid(count.max(1) as isize) as usize
}

impl App {
    /// Does what keys that were pressed since the last frame say.
    pub(crate) fn keys(&mut self, ctx: &egui::Context) {
        let events = ctx.input(|input| input.events.clone());
        for event in &events {
            let Some(picker) = &mut self.picker else {
                if let Some((action, is_fine)) = action_of(ctx, event) {
                    self.act(ctx, action, is_fine);
                }
                continue;
            };
            match picker.take_event(event) {
                Outcome::Open => {}
                Outcome::Closed => self.picker = None,
                Outcome::Chosen(taken) => {
                    self.picker = None;
                    picker::take(self, ctx, taken);
                }
            }
        }
    }

    /// Whether keys that are down move the view.
    pub(crate) fn is_steered(&self, ctx: &egui::Context) -> bool {
        self.hears_keys(ctx) && flight(ctx) != (Vec3::ZERO, Vec2::ZERO)
    }

    /// Whether nothing is being typed.
    fn hears_keys(&self, ctx: &egui::Context) -> bool {
        self.picker.is_none() && !ctx.text_edit_focused()
    }

    fn act(&mut self, ctx: &egui::Context, action: Action, is_fine: bool) {
        let settings = &mut self.settings;
        match action {
            Action::Help => settings.shows_help = !settings.shows_help,
            Action::Choose(choice) => {
                // Enter is the list's now, not the panel's.
                if let Some(id) = ctx.memory(|memory| memory.focused()) {
                    ctx.memory_mut(|memory| memory.surrender_focus(id));
                }
                self.picker = Some(Picker::new(choice));
            }
            Action::Failure(by) => self.next_failure(ctx, by),
            Action::Play => self.play_or_pause(),
            Action::Split => settings.split = settings.split.is_none().then_some(0.5),
            Action::Flip => {
                settings.split = None;
                settings.shown_side = 1 - settings.shown_side;
            }
            Action::Divide(steps) => {
                let at = settings.split.unwrap_or(0.5) + steps * DIVIDER_STEP;
                settings.split = Some(at.clamp(0.0, 1.0));
            }
            Action::Error => {
                settings.picture = match settings.picture {
                    Picture::Error => Picture::Nothing,
                    _ => Picture::Error,
                };
                self.compare();
            }
            Action::Picture(by) => {
                let is_it = |(picture, _): &(Picture, &str)| *picture == settings.picture;
                let at = Picture::ALL.iter().position(is_it).unwrap_or(0);
                settings.picture = Picture::ALL[stepped(at, by, Picture::ALL.len())].0;
                self.compare();
            }
            Action::Plan if self.plan_job.at().is_some() => self.plan_job.cancel(),
            Action::Plan => self.start_plan(ctx),
            Action::ShowPlan => self.show_plan(),
            Action::Copy(nth) => {
                let first = match settings.split {
                    Some(_) => 0,
                    None => settings.shown_side,
                };
                self.copy_preset(ctx, if nth == 0 { first } else { 1 - first });
            }
            Action::Maps => settings.shows_maps = !settings.shows_maps,
            Action::Fold => panel::fold(self, ctx),
            Action::Home => {
                settings.view = ViewCamera::new(&self.stage.camera, &self.stage.bounds);
                self.touch();
            }
            Action::Orbit => {
                settings.view.mode = match settings.view.mode {
                    Mode::Fly => Mode::Orbit,
                    Mode::Orbit => Mode::Fly,
                };
            }
            Action::Near(steps) => {
                // With the rest that moves the view: it may be under way along a path.
                self.steps_nearer += steps;
            }
            Action::Screenshot => self.ask_for_screenshot(ctx),
            Action::Zoom(by) => {
                // The window's own follows with the next frame, and a key may be pressed twice before.
                let before = settings.zoom.unwrap_or_else(|| ctx.zoom_factor());
                // Whole tenths, whatever the automatic zoom was.
                let zoom = (10.0 * (before + by)).round() / 10.0;
                settings.zoom = Some(zoom.clamp(0.5, 5.0));
            }
            Action::AutomaticZoom => settings.zoom = None,
            Action::Quit => ctx.send_viewport_cmd(egui::ViewportCommand::Close),
            Action::Leave => self.leave(),
            of_lights => self.act_on_lights(of_lights, is_fine),
        }
    }

    fn act_on_lights(&mut self, action: Action, is_fine: bool) {
        let bounds = self.stage.bounds;
        let settings = &mut self.settings;
        let count = settings.lights.len();
        match action {
            Action::Light(by) => settings.chosen = stepped(settings.chosen, by, count),
            Action::AddLight if count < MAX_LIGHTS => {
                settings.lights.push(EditLight::above(&bounds));
                settings.chosen = count;
            }
            Action::RemoveLight if settings.chosen < count => {
                settings.lights.remove(settings.chosen);
                settings.chosen = settings.chosen.saturating_sub(1);
            }
            Action::LightOn => {
                if let Some(light) = settings.lights.get_mut(settings.chosen) {
                    light.is_on = !light.is_on;
                }
            }
            Action::Turns => self.handles.turns = !self.handles.turns,
            Action::MoveLight(way) => {
                let factor = if is_fine { FINE } else { 1.0 };
                self.move_light(way * factor);
            }
            _ => return,
        }
        self.touch();
    }

    /// Moves the chosen light by steps as they look from the camera, or turns it.
    fn move_light(&mut self, steps: Vec3) {
        let settings = &mut self.settings;
        let looked_at = settings.view.looked_at();
        let Some(light) = settings.lights.get_mut(settings.chosen) else {
            return;
        };
        // Level, so that the light keeps its height unless that is asked for.
        let ahead = (settings.view.ahead() * Vec3::new(1.0, 0.0, 1.0)).normalize_or(Vec3::NEG_Z);
        let right = ahead.cross(Vec3::Y);
        if self.handles.turns && light.can_turn() {
            let turn = |axis, angle| Quat::from_axis_angle(axis, LIGHT_TURN * angle);
            light.turn(turn(Vec3::Y, steps.x) * turn(right, steps.z) * turn(ahead, steps.y));
            return;
        }
        let step = LIGHT_STEP * 2.0 * looked_at.reach;
        let by = (right * steps.x + Vec3::Y * steps.y + ahead * steps.z) * step;
        light.move_marker(light.marker(&looked_at) + by, &looked_at);
    }

    /// Opens the next place of failure, or the one before.
    fn next_failure(&mut self, ctx: &egui::Context, by: isize) {
        let all = bookmarks::all();
        // While one is on its way, the next is the one after that.
        let name = match (self.loader.then(), &self.path) {
            (Some(Then::Compare(coming)), _) => coming.name,
            (_, Some(path)) => path.moving.name,
            _ => self.stage.argument.as_str(),
        };
        let present = all.iter().position(|bookmark| bookmark.name == name);
        let next = match present {
            Some(at) => stepped(at, by, all.len()),
            None => 0,
        };
        if let Some(bookmark) = all.get(next) {
            self.open(ctx, bookmark.scene, Then::Compare(*bookmark));
        }
    }

    /// Closes what lies over the picture; if nothing does, gives up what is being read.
    fn leave(&mut self) {
        if self.settings.shows_help {
            self.settings.shows_help = false;
        } else if self.message.is_some() {
            self.message = None;
        } else {
            self.give_up_loading();
        }
    }

    /// Reads keys that are held and the mouse over the picture. Returns whether the view moved.
    pub(crate) fn steer(
        &mut self,
        ui: &egui::Ui,
        response: &egui::Response,
        passed: Duration,
    ) -> bool {
        let before = self.settings.view;
        let ctx = ui.ctx();
        let hears_keys = self.hears_keys(ctx);
        let view = &mut self.settings.view;
        if response.dragged_by(egui::PointerButton::Secondary) {
            let moved = response.drag_motion();
            view.turn(Vec2::new(moved.x, moved.y));
        }
        if response.dragged_by(egui::PointerButton::Middle) {
            let moved = response.drag_delta();
            view.pan(Vec2::new(moved.x, moved.y), response.rect.height());
        }
        let steps = std::mem::take(&mut self.steps_nearer);
        if steps != 0.0 {
            view.step(steps);
        }
        if response.hovered() {
            let lines = ctx.input(|input| input.smooth_scroll_delta().y) / 40.0;
            if lines != 0.0 {
                view.step(lines);
            }
        }
        if hears_keys {
            let (way, turn) = flight(ctx);
            let is_fast = ctx.input(|input| input.modifiers.shift);
            // A long frame is no long flight.
            let seconds = passed.as_secs_f32().min(0.2);
            let factor = if is_fast { 4.0 } else { 1.0 };
            if way != Vec3::ZERO {
                view.fly(way, factor * seconds);
            }
            if turn != Vec2::ZERO {
                view.turn(turn * (LOOK * seconds));
            }
        }
        *view != before
    }
}

/// Returns where the keys that are down fly (to the right, up and forward), and how they turn (to the right and down).
fn flight(ctx: &egui::Context) -> (Vec3, Vec2) {
    ctx.input(|input| {
        if input.modifiers.command {
            return (Vec3::ZERO, Vec2::ZERO);
        }
        let down = |key| f32::from(u8::from(input.key_down(key)));
        let along = |less, more| down(more) - down(less);
        let way = Vec3::new(
            along(Key::A, Key::D),
            along(Key::Q, Key::E),
            along(Key::S, Key::W),
        );
        (way, Vec2::new(along(Key::J, Key::L), along(Key::I, Key::K)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_key_does_two_things() {
        let bound: Vec<_> = KEYS.iter().flat_map(|keys| keys.actions).collect();
        let held = [
            Modifiers::NONE,
            Modifiers::SHIFT,
            Modifiers::COMMAND | Modifiers::CTRL,
        ];
        for (i, (with, key, _)) in bound.iter().enumerate() {
            for (other, of, _) in &bound[..i] {
                let both = held.iter().any(|m| with.is_held(*m) && other.is_held(*m));
                assert!(key != of || !both, "{key:?}");
            }
        }
    }

    #[test]
    fn steps_go_round() {
        assert_eq!(
            (stepped(0, -1, 3), stepped(2, 1, 3), stepped(0, 1, 0)),
            (2, 0, 0)
        );
    }
}
