//! The keys: one table of their actions, which is also the help of F1.

use crate::{
    bookmarks,
    camera::ViewCamera,
    loading::Then,
    measure::pictures::Picture,
    picker::{Choice, Chosen, Outcome, Picker},
    side::entry,
    viewer::Viewer,
};
use egui::{Key, Modifiers};
use umbrage::glam::{Quat, Vec3};

/// Modifiers that are held with a key.
#[derive(Clone, Copy)]
pub(crate) enum With {
    Nothing,
    Shift,
    /// Shift or not.
    Any,
    /// Ctrl, or the command key of a Mac.
    Command,
}

/// A key press.
pub(crate) struct Press<'a> {
    ctx: &'a egui::Context,
    has_shift: bool,
}

/// A key and its action.
type KeyBinding = (With, Key, fn(&mut Viewer, &Press<'_>));

/// A step of the divider, as a fraction of the width.
const DIVIDER_STEP: f32 = 0.02;
/// A step of moving a light, as a fraction of the visible width.
const LIGHT_STEP: f32 = 0.04;
/// A step of turning a light, radians: two degrees.
const LIGHT_TURN: f32 = 0.035;
/// Factor of the steps of lights with shift.
const FINE: f32 = 0.1;

#[cfg(not(target_arch = "wasm32"))]
const SCREENSHOT: &str = "saves a screenshot";
/// Browsers have no folders for screenshots, and use the key themselves.
#[cfg(target_arch = "wasm32")]
const SCREENSHOT: &str = "use the browser's screenshots";

/// Keys that belong to the panel while one of its parts has the focus: arrows select the next part,
/// and space presses a button.
const KEYS_OF_PANEL: [Key; 7] = [
    Key::ArrowLeft,
    Key::ArrowRight,
    Key::ArrowDown,
    Key::ArrowUp,
    Key::PageDown,
    Key::PageUp,
    Key::Space,
];

/// Lines of the help: keys, their action, and its implementation. The mouse, held keys, and the
/// panel's keys are handled elsewhere.
pub(crate) const KEYS: [(&str, &str, &[KeyBinding]); 36] = {
    use With::{Any, Command, Nothing, Shift};
    [
        ("W A S D, E Q", "fly; faster with Shift", &[]),
        ("J L, I K", "look around, or orbit", &[]),
        ("right mouse button", "look around, or orbit", &[]),
        ("middle button, wheel", "pan; move ahead and back", &[]),
        (
            "O",
            "switch between fly and orbit",
            &[(Nothing, Key::O, |v, _| v.settings.view.switch_mode())],
        ),
        (
            "plus, minus",
            "move ahead and back; zoom in orbit",
            &[
                (Any, Key::Plus, |v, _| v.steps_nearer += 1.0),
                (Any, Key::Equals, |v, _| v.steps_nearer += 1.0),
                (Any, Key::Minus, |v, _| v.steps_nearer -= 1.0),
            ],
        ),
        (
            "Home",
            "reset the view",
            &[(Nothing, Key::Home, |v, _| v.go_home())],
        ),
        (
            "F2",
            "open a scene or a file",
            &[(Nothing, Key::F2, |v, press| v.pick(press, Choice::Scene))],
        ),
        (
            "F3",
            "open a failure",
            &[(Nothing, Key::F3, |v, press| v.pick(press, Choice::Failure))],
        ),
        (
            "B, Shift B",
            "next or previous failure",
            &[
                (Nothing, Key::B, |v, press| v.open_next_failure(press, 1)),
                (Shift, Key::B, |v, press| v.open_next_failure(press, -1)),
            ],
        ),
        (
            "Space",
            "start or pause the motion",
            &[(Nothing, Key::Space, |v, _| v.toggle_motion())],
        ),
        (
            "1, 2",
            "choose the left or right technique",
            &[
                (Nothing, Key::Num1, |v, press| {
                    v.pick(press, Choice::Technique(0))
                }),
                (Nothing, Key::Num2, |v, press| {
                    v.pick(press, Choice::Technique(1))
                }),
            ],
        ),
        (
            "X",
            "show both sides, or one",
            &[(Nothing, Key::X, |v, _| {
                v.settings.split = v.settings.split.is_none().then_some(0.5)
            })],
        ),
        ("F", "switch sides", &[(Nothing, Key::F, |v, _| v.flip())]),
        (
            "comma, period",
            "move the divider",
            &[
                (Nothing, Key::Comma, |v, _| v.move_divider(-DIVIDER_STEP)),
                (Nothing, Key::Period, |v, _| v.move_divider(DIVIDER_STEP)),
            ],
        ),
        (
            "H",
            "show errors",
            &[(Nothing, Key::H, |v, press| v.switch_errors(press))],
        ),
        (
            "V, Shift V",
            "next or previous overlay",
            &[
                (Nothing, Key::V, |v, press| v.show_next_picture(press, 1)),
                (Shift, Key::V, |v, press| v.show_next_picture(press, -1)),
            ],
        ),
        ("click on a light", "select it; drag its handles", &[]),
        (
            "N, Shift N",
            "next or previous light",
            &[
                (Nothing, Key::N, |v, _| v.choose_next_light(1)),
                (Shift, Key::N, |v, _| v.choose_next_light(-1)),
            ],
        ),
        (
            "arrows, Page Up, Down",
            "move or turn the light; finely with Shift",
            &[
                (Any, Key::ArrowLeft, |v, press| {
                    v.move_light(press, Vec3::NEG_X)
                }),
                (Any, Key::ArrowRight, |v, press| {
                    v.move_light(press, Vec3::X)
                }),
                (Any, Key::ArrowDown, |v, press| {
                    v.move_light(press, Vec3::NEG_Z)
                }),
                (Any, Key::ArrowUp, |v, press| v.move_light(press, Vec3::Z)),
                (Any, Key::PageDown, |v, press| {
                    v.move_light(press, Vec3::NEG_Y)
                }),
                (Any, Key::PageUp, |v, press| v.move_light(press, Vec3::Y)),
            ],
        ),
        (
            "R",
            "turn or move by handles and arrows",
            &[(Nothing, Key::R, |v, _| v.handles.turns = !v.handles.turns)],
        ),
        (
            "G",
            "switch the light on or off",
            &[(Nothing, Key::G, |v, _| v.switch_light())],
        ),
        (
            "Insert, Delete",
            "add a light, remove the selected one",
            &[
                (Nothing, Key::Insert, |v, _| {
                    v.settings.add_light(&v.stage.bounds)
                }),
                (Nothing, Key::Delete, |v, _| v.settings.remove_light()),
            ],
        ),
        (
            "P",
            "search the cheapest technique, or cancel",
            &[(Nothing, Key::P, |v, press| v.start_or_cancel_plan(press))],
        ),
        (
            "Shift P",
            "show the result on the left",
            &[(Shift, Key::P, |v, _| v.show_plan())],
        ),
        (
            "C, Shift C",
            "copy the shown (or left) preset, the other",
            &[
                (Nothing, Key::C, |v, press| {
                    v.copy_preset(press.ctx, v.first_side())
                }),
                (Shift, Key::C, |v, press| {
                    v.copy_preset(press.ctx, 1 - v.first_side())
                }),
            ],
        ),
        (
            "F4",
            "fold or unfold the panel",
            &[(Nothing, Key::F4, |v, press| v.fold(press.ctx))],
        ),
        (
            "M",
            "show the maps",
            &[(Nothing, Key::M, |v, _| {
                v.settings.shows_maps = !v.settings.shows_maps
            })],
        ),
        (
            "Tab, Shift Tab",
            "move through the panel; Enter presses",
            &[],
        ),
        (
            "arrows in the panel",
            "move to neighbours; change sliders",
            &[],
        ),
        (
            "Esc",
            "leave the panel, close, cancel loading",
            &[(Any, Key::Escape, |v, _| v.leave())],
        ),
        (
            "Ctrl plus, minus",
            "larger and smaller text",
            &[
                (Command, Key::Plus, |v, press| v.zoom_by(press, 0.1)),
                (Command, Key::Equals, |v, press| v.zoom_by(press, 0.1)),
                (Command, Key::Minus, |v, press| v.zoom_by(press, -0.1)),
            ],
        ),
        (
            "Ctrl 0",
            "automatic size of text",
            &[(Command, Key::Num0, |v, _| v.settings.zoom = None)],
        ),
        (
            "F12",
            SCREENSHOT,
            &[(Nothing, Key::F12, |v, press| {
                v.request_screenshot(press.ctx)
            })],
        ),
        (
            "F1",
            "show these keys",
            &[(Nothing, Key::F1, |v, _| {
                v.settings.shows_help = !v.settings.shows_help
            })],
        ),
        (
            "Ctrl Q",
            "quit",
            &[(Command, Key::Q, |_, press| {
                press.ctx.send_viewport_cmd(egui::ViewportCommand::Close)
            })],
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
            // Plus requires shift on many keyboards.
            Self::Command => modifiers.command,
        }
    }
}

/// Returns the next of `count` indices, or the previous one, cyclically.
fn step_index(at: usize, by: isize, count: usize) -> usize {
    (at as isize + by).rem_euclid(count.max(1) as isize) as usize
}

impl Viewer {
    /// Handles key presses since the last frame.
    pub(crate) fn keys(&mut self, ctx: &egui::Context) {
        let events = ctx.input(|input| input.events.clone());
        for event in &events {
            let Some(picker) = &mut self.picker else {
                self.press(ctx, event);
                continue;
            };
            match picker.take_event(event) {
                Outcome::Open => {}
                Outcome::Closed => self.picker = None,
                Outcome::Chosen(chosen) => {
                    self.picker = None;
                    self.show_chosen(ctx, chosen);
                }
            }
        }
    }

    fn press(&mut self, ctx: &egui::Context, event: &egui::Event) {
        let egui::Event::Key {
            key,
            pressed: true,
            modifiers,
            ..
        } = event
        else {
            return;
        };
        let mut bound = KEYS.iter().flat_map(|(_, _, bound)| *bound);
        let pressed = bound.find(|(with, of, _)| of == key && with.is_held(*modifiers));
        let Some((with, _, act)) = pressed else {
            return;
        };
        let is_in_panel = ctx.memory(|memory| memory.focused().is_some());
        let is_of_panel = ctx.text_edit_focused() || is_in_panel && KEYS_OF_PANEL.contains(key);
        if matches!(with, With::Command) || !is_of_panel {
            let has_shift = modifiers.shift;
            act(self, &Press { ctx, has_shift });
        }
    }

    /// Applies a choice from a list.
    pub(crate) fn show_chosen(&mut self, ctx: &egui::Context, chosen: Chosen) {
        match chosen {
            Chosen::Scene(name) => self.open(ctx, &name, Then::Show),
            Chosen::Failure(bookmark) => self.open(ctx, bookmark.scene, Then::Compare(bookmark)),
            Chosen::Technique(side, name) => {
                self.settings.sides[side].choose(entry(name));
                self.forget_side(side);
            }
        }
    }

    fn pick(&mut self, press: &Press<'_>, choice: Choice) {
        // Give Enter to the list instead of the panel.
        press.ctx.memory_mut(|memory| {
            if let Some(id) = memory.focused() {
                memory.surrender_focus(id);
            }
        });
        self.picker = Some(Picker::new(choice));
    }

    fn go_home(&mut self) {
        self.settings.view = ViewCamera::new(&self.stage.camera, &self.stage.bounds);
        self.pace.touch();
    }

    fn flip(&mut self) {
        self.settings.split = None;
        self.settings.shown_side = 1 - self.settings.shown_side;
    }

    fn move_divider(&mut self, by: f32) {
        let at = self.settings.split.unwrap_or(0.5) + by;
        self.settings.split = Some(at.clamp(0.0, 1.0));
    }

    fn switch_errors(&mut self, press: &Press<'_>) {
        self.settings.picture = match self.settings.picture {
            Picture::Error => Picture::Nothing,
            _ => Picture::Error,
        };
        self.compare(press.ctx);
    }

    fn show_next_picture(&mut self, press: &Press<'_>, by: isize) {
        let is_shown = |(picture, _): &(Picture, &str)| *picture == self.settings.picture;
        let at = Picture::ALL.iter().position(is_shown).unwrap_or(0);
        self.settings.picture = Picture::ALL[step_index(at, by, Picture::ALL.len())].0;
        self.compare(press.ctx);
    }

    fn start_or_cancel_plan(&mut self, press: &Press<'_>) {
        if self.planning.take().is_none() {
            self.start_plan(press.ctx);
        }
    }

    /// Returns the shown side, or the left one.
    fn first_side(&self) -> usize {
        match self.settings.split {
            Some(_) => 0,
            None => self.settings.shown_side,
        }
    }

    fn zoom_by(&mut self, press: &Press<'_>, by: f32) {
        // The window's own zoom changes with the next frame, and a key may be pressed twice before.
        let chosen = self.settings.zoom;
        let before = chosen.unwrap_or_else(|| press.ctx.zoom_factor());
        // Round to tenths, in case the automatic zoom is not a multiple.
        let zoom = (10.0 * (before + by)).round() / 10.0;
        self.settings.zoom = Some(zoom.clamp(0.5, 5.0));
    }

    fn choose_next_light(&mut self, by: isize) {
        let count = self.settings.lights.len();
        self.settings.chosen = step_index(self.settings.chosen, by, count);
        self.pace.touch();
    }

    fn switch_light(&mut self) {
        if let Some(light) = self.settings.lights.get_mut(self.settings.chosen) {
            light.is_on = !light.is_on;
        }
    }

    /// Moves the selected light by steps to the right, up, and away from the eye, or turns it.
    fn move_light(&mut self, press: &Press<'_>, direction: Vec3) {
        let steps = direction * if press.has_shift { FINE } else { 1.0 };
        let settings = &mut self.settings;
        let looked_at = settings.view.looked_at();
        let Some(light) = settings.lights.get_mut(settings.chosen) else {
            return;
        };
        // Move horizontally, so that the light keeps its height.
        let ahead = (settings.view.forward_direction() * Vec3::new(1.0, 0.0, 1.0))
            .normalize_or(Vec3::NEG_Z);
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

    /// Opens the next failure, or the previous one.
    fn open_next_failure(&mut self, press: &Press<'_>, by: isize) {
        let all = bookmarks::all();
        // While a failure is loading, continue from that one.
        let loading = self.loading.as_ref().map(|loading| &loading.request.then);
        let name = match (loading, &self.path) {
            (Some(Then::Compare(coming)), _) => coming.name,
            (_, Some(path)) => path.moving.name,
            _ => self.stage.argument.as_str(),
        };
        let present = all.iter().position(|bookmark| bookmark.name == name);
        let next = present.map_or(0, |at| step_index(at, by, all.len()));
        if let Some(bookmark) = all.get(next) {
            self.open(press.ctx, bookmark.scene, Then::Compare(*bookmark));
        }
    }

    /// Closes the help or the message, or else cancels loading.
    fn leave(&mut self) {
        if self.settings.shows_help {
            self.settings.shows_help = false;
        } else if self.message.take().is_none() {
            self.cancel_loading();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_key_does_two_things() {
        let bound: Vec<_> = KEYS.iter().flat_map(|(_, _, bound)| *bound).collect();
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
            (
                step_index(0, -1, 3),
                step_index(2, 1, 3),
                step_index(0, 1, 0)
            ),
            (2, 0, 0)
        );
    }
}
