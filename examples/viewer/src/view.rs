//! The image in the window, with the divider and the lights' markers and handles.

use crate::{gizmo, render::FrameSettings, viewer::Viewer};
use anyhow::Result;
use egui::{Color32, Rect, Sense, Stroke};
use umbrage::{Camera, glam::UVec2};
use web_time::{Duration, Instant};

impl Viewer {
    /// Draws the scene, and shows it in the rest of the window.
    pub(crate) fn show_picture(&mut self, ui: &mut egui::Ui, passed: Duration) -> Result<()> {
        let rect = ui.available_rect_before_wrap();
        // Exclude it from Tab, since it has no action.
        let response = ui.allocate_rect(rect, Sense::CLICK | Sense::DRAG);
        self.steer(ui, &response, passed);
        self.follow_path(passed);
        self.pixels = pixels_of(rect, ui.ctx().pixels_per_point());
        let is_moving = !self.pace.rests();
        if is_moving && self.pace.was_moving {
            self.adapt_scale(passed);
        }
        self.pace.was_moving = is_moving;
        let scale = self.pace.frame_scale(is_moving);
        let most = self.render.device.limits().max_texture_dimension_2d as f32;
        let side = |length: u32| (length as f32 * scale).round().clamp(1.0, most) as u32;
        let size = UVec2::new(side(self.pixels.x), side(self.pixels.y));
        let camera = self.camera_of_size(size);
        let begin = Instant::now();
        let view = self.renderer.frame(&FrameSettings {
            camera: &camera,
            stage: &self.stage,
            settings: &self.settings,
            is_moving,
            is_coarse: is_moving && scale < 1.0,
        })?;
        let shape = self.presenter.shape(rect, view, size, self.pixels);
        self.camera = Some(camera);
        self.pace.work = begin.elapsed();
        ui.painter_at(rect).add(shape);
        self.show_divider(ui, rect);
        self.show_lights(ui, rect, &camera);
        if self.pace.is_fresh() {
            ui.ctx().request_repaint();
        }
        Ok(())
    }

    /// Reduces the number of pixels while something moves and frames take long, and increases it
    /// again afterwards.
    fn adapt_scale(&mut self, passed: Duration) {
        let device_type = self.render.adapter.get_info().device_type;
        if device_type == wgpu::DeviceType::Cpu || self.renderer.clock.is_none() {
            self.pace.adapt_to_interval(passed);
        } else if let Some((size, took)) = self.renderer.take_moving_frame() {
            let scale = size.x as f32 / self.pixels.x.max(1) as f32;
            self.pace.adapt_to_device(scale, took);
        }
    }

    fn show_divider(&mut self, ui: &egui::Ui, rect: Rect) {
        let Some(divider) = &mut self.settings.split else {
            return;
        };
        let x = egui::lerp(rect.x_range(), *divider);
        let grip = Rect::from_x_y_ranges(x - 6.0..=x + 6.0, rect.y_range());
        let response = ui.interact(grip, ui.scope_id().with("divider"), Sense::DRAG);
        if response.hovered() || response.dragged() {
            ui.ctx().set_cursor_icon(egui::CursorIcon::ResizeHorizontal);
        }
        if let Some(pointer) = response.interact_pointer_pos()
            && response.dragged()
        {
            *divider = ((pointer.x - rect.min.x) / rect.width()).clamp(0.0, 1.0);
        }
        for stroke in [
            Stroke::new(3.0, Color32::BLACK),
            Stroke::new(1.5, Color32::WHITE),
        ] {
            ui.painter_at(rect).vline(x, rect.y_range(), stroke);
        }
    }

    fn show_lights(&mut self, ui: &egui::Ui, rect: Rect, camera: &Camera) {
        let settings = &mut self.settings;
        let looked_at = &settings.view.looked_at();
        let (lights, chosen) = (&mut settings.lights, &mut settings.chosen);
        gizmo::markers(ui, rect, camera, looked_at, lights, chosen);
        self.marker = None;
        if let Some(light) = lights.get_mut(*chosen) {
            self.marker = gizmo::position_in(rect, camera, light.marker(looked_at));
            if self.handles.show(ui, rect, camera, looked_at, light) {
                self.pace.touch();
            }
        }
    }
}

/// Returns the size of a part of the window, pixels, with edges as the panel's painter places them.
fn pixels_of(rect: Rect, pixels_per_point: f32) -> UVec2 {
    let between = |from: f32, to: f32| {
        let [from, to] = [from, to].map(|edge| (edge * pixels_per_point).round());
        (to - from).max(0.0) as u32
    };
    UVec2::new(
        between(rect.min.x, rect.max.x),
        between(rect.min.y, rect.max.y),
    )
}
