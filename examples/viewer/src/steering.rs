//! Control of the view: by held keys, by the mouse over the image, and along the path of a failure.

use crate::{
    path::{FITTED, UnderWay},
    viewer::Viewer,
};
use egui::{Key, PointerButton};
use umbrage::glam::{Vec2, Vec3};
use web_time::Duration;

/// Rotation by keys in a second, in points of mouse movement.
const LOOK: f32 = 350.0;
/// Greatest motion in a frame, seconds, so that a long frame is not a long flight.
const LONGEST: f32 = 0.2;

impl Viewer {
    /// Reports whether held keys move the view.
    pub(crate) fn is_steered(&self, ctx: &egui::Context) -> bool {
        self.flight(ctx) != (Vec3::ZERO, Vec2::ZERO)
    }

    /// Returns the flight by held keys (to the right, up and forward), and the rotation (to the
    /// right and down).
    fn flight(&self, ctx: &egui::Context) -> (Vec3, Vec2) {
        let is_typing = self.picker.is_some() || ctx.text_edit_focused();
        ctx.input(|input| {
            if is_typing || input.modifiers.command {
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

    /// Moves the view by the user's input. Input ends a path at its current position.
    pub(crate) fn steer(&mut self, ui: &egui::Ui, response: &egui::Response, passed: Duration) {
        let begun = self.settings.view;
        if let Some(path) = self.path.as_ref().filter(|path| path.under_way.is_some()) {
            let camera = path.camera(&begun.camera(FITTED));
            self.settings.view = begun.seen_as(&camera, &self.stage.bounds);
        }
        let before = self.settings.view;
        self.move_view(ui, response, passed);
        if self.settings.view == before {
            self.settings.view = begun;
            return;
        }
        self.pace.touch();
        self.end_path();
    }

    fn move_view(&mut self, ui: &egui::Ui, response: &egui::Response, passed: Duration) {
        let ctx = ui.ctx();
        let (way, turn) = self.flight(ctx);
        let view = &mut self.settings.view;
        if response.dragged_by(PointerButton::Secondary) {
            let moved = response.drag_motion();
            view.turn(Vec2::new(moved.x, moved.y));
        }
        if response.dragged_by(PointerButton::Middle) {
            let moved = response.drag_delta();
            view.pan(Vec2::new(moved.x, moved.y), response.rect.height());
        }
        let mut steps = std::mem::take(&mut self.steps_nearer);
        if response.hovered() {
            steps += ctx.input(|input| input.smooth_scroll_delta().y) / 40.0;
        }
        if steps != 0.0 {
            view.step(steps);
        }
        let is_fast = ctx.input(|input| input.modifiers.shift);
        let factor = if is_fast { 4.0 } else { 1.0 };
        let seconds = passed.as_secs_f32().min(LONGEST);
        if way != Vec3::ZERO {
            view.fly(way, factor * seconds);
        }
        if turn != Vec2::ZERO {
            view.turn(turn * (LOOK * seconds));
        }
    }

    fn end_path(&mut self) {
        if let Some(path) = &mut self.path {
            path.is_running = false;
            path.under_way = None;
        }
    }

    /// Advances along the path. A movement of the camera or the light by the user ends it.
    pub(crate) fn follow_path(&mut self, passed: Duration) {
        let Some(path) = &self.path else {
            return;
        };
        let view = self.settings.view;
        let light = self.settings.lights.first().map(|light| light.light);
        let is_as_left = path
            .under_way
            .as_ref()
            .is_none_or(|under_way| under_way.view.has_pose_of(&view) && path.light() == light);
        if !is_as_left {
            self.end_path();
        }
        let Some(path) = self.path.as_mut().filter(|path| path.is_running) else {
            return;
        };
        let under_way = path.under_way.get_or_insert(UnderWay {
            view,
            light,
            seconds: 0.0,
        });
        // Keep changed settings of the camera: mode, speed, projection.
        under_way.view = view;
        under_way.seconds += passed.as_secs_f32().min(LONGEST);
        if let (Some(light), Some(to)) = (self.settings.lights.first_mut(), path.light()) {
            light.light = to;
        }
        self.pace.touch();
    }

    /// Starts or pauses the path.
    pub(crate) fn toggle_motion(&mut self) {
        match &mut self.path {
            Some(path) => path.is_running = !path.is_running,
            None => {
                self.message = Some("This scene has no motion. Press F3 and choose a failure in motion, such as hills-pan.".to_owned());
            }
        }
    }
}
