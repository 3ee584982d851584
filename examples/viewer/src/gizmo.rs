//! Markers of lights, and handles for dragging and turning them.

use crate::lights::{EditLight, LookedAt};
use transform_gizmo::{
    EnumSet, Gizmo, GizmoConfig, GizmoInteraction, GizmoMode, GizmoOrientation, GizmoResult,
    math::Transform, mint,
};
use umbrage::{
    Camera, Light,
    glam::{DMat4, DQuat, Mat4, Quat, Vec3},
};

/// Radius of a marker, points.
const MARKER: f32 = 9.0;

/// Handles of the selected light.
#[derive(Default)]
pub(crate) struct LightHandles {
    gizmo: Gizmo,
    /// `true` if they turn the light instead of moving it.
    pub turns: bool,
    /// `true` if the mouse holds a handle.
    pub is_held: bool,
}

/// Returns the position of a world point in the image, points. `None` behind the camera.
pub(crate) fn position_in(rect: egui::Rect, camera: &Camera, point: Vec3) -> Option<egui::Pos2> {
    let clip = camera.space().clip_from_world() * point.extend(1.0);
    if clip.w <= 0.0 {
        return None;
    }
    let unit = [0.5 + 0.5 * clip.x / clip.w, 0.5 - 0.5 * clip.y / clip.w];
    Some(rect.lerp_inside(egui::vec2(unit[0], unit[1])))
}

/// Draws a marker at each light. A click on a marker selects its light.
pub(crate) fn markers(
    ui: &egui::Ui,
    rect: egui::Rect,
    camera: &Camera,
    looked_at: &LookedAt,
    lights: &[EditLight],
    chosen: &mut usize,
) {
    let painter = ui.painter_at(rect);
    for (i, light) in lights.iter().enumerate() {
        let Some(at) = position_in(rect, camera, light.marker(looked_at)) else {
            continue;
        };
        if !rect.contains(at) {
            continue;
        }
        let area = egui::Rect::from_center_size(at, egui::Vec2::splat(3.0 * MARKER));
        let response = ui.interact(area, ui.scope_id().with(("light", i)), egui::Sense::click());
        if response.clicked() {
            *chosen = i;
        }
        let [r, g, b] = light.color.map(|c| (255.0 * c.clamp(0.0, 1.0)) as u8);
        let fill = if light.is_on {
            egui::Color32::from_rgb(r, g, b)
        } else {
            egui::Color32::from_gray(90)
        };
        let width = if i == *chosen { 2.5 } else { 1.0 };
        let ring = egui::Stroke::new(width, egui::Color32::BLACK);
        draw_marker(&painter, at, &light.light, fill, ring);
        response.on_hover_text(format!("light {}: {}", i + 1, light.light.kind()));
    }
}

fn draw_marker(
    painter: &egui::Painter,
    at: egui::Pos2,
    light: &Light,
    fill: egui::Color32,
    ring: egui::Stroke,
) {
    // A sun has rays, rectangles are squares, and other lights are round.
    match light {
        Light::Rect { .. } => {
            let square = egui::Rect::from_center_size(at, egui::Vec2::splat(1.8 * MARKER));
            painter.rect(square, 1.0, fill, ring, egui::StrokeKind::Middle);
        }
        Light::Directional { .. } => {
            for i in 0..8 {
                let angle = std::f32::consts::TAU * i as f32 / 8.0;
                let way = egui::Vec2::angled(angle);
                let ray = [at + way * (1.15 * MARKER), at + way * (1.7 * MARKER)];
                painter.line_segment(ray, egui::Stroke::new(4.0, egui::Color32::BLACK));
                painter.line_segment(ray, egui::Stroke::new(2.0, fill));
            }
            painter.circle(at, 0.85 * MARKER, fill, ring);
        }
        _ => {
            painter.circle(at, MARKER, fill, ring);
        }
    }
}

impl LightHandles {
    /// Number of pixels for each point of the window.
    pub(crate) fn pixels_per_point(&self) -> f32 {
        self.gizmo.config().pixels_per_point
    }

    /// Draws the selected light's handles, and moves or turns the light as they are dragged.
    /// Returns whether it changed.
    pub(crate) fn show(
        &mut self,
        ui: &egui::Ui,
        rect: egui::Rect,
        camera: &Camera,
        looked_at: &LookedAt,
        light: &mut EditLight,
    ) -> bool {
        let turns = self.turns && light.can_turn();
        let modes = if turns {
            GizmoMode::all_rotate()
        } else {
            GizmoMode::all_translate()
        };
        self.configure(ui, rect, camera, modes);
        let at = light.marker(looked_at);
        let target = Transform {
            scale: mint::Vector3 {
                x: 1.0,
                y: 1.0,
                z: 1.0,
            },
            rotation: DQuat::IDENTITY.to_array().into(),
            translation: at.as_dvec3().to_array().into(),
        };
        let pointer = ui.input(|input| input.pointer.clone());
        let cursor = pointer.hover_pos().unwrap_or_default();
        // Windows over the image capture the pointer.
        let is_on_top = ui.ctx().layer_id_at(cursor) == Some(ui.layer_id());
        let is_over_picture = rect.contains(cursor) && is_on_top;
        let interaction = GizmoInteraction {
            cursor_pos: (cursor.x, cursor.y),
            hovered: is_over_picture || self.is_held,
            drag_started: is_over_picture && pointer.primary_pressed(),
            dragging: pointer.primary_down(),
        };
        let moved = self.gizmo.update(interaction, &[target]);
        self.is_held = moved.is_some();
        self.draw(ui, rect);
        let Some((result, places)) = moved else {
            return false;
        };
        match result {
            GizmoResult::Rotation { axis, delta, .. } => {
                let axis: [f64; 3] = axis.into();
                let axis = Vec3::from(axis.map(|x| x as f32));
                light.turn(Quat::from_axis_angle(
                    axis.normalize_or(Vec3::Y),
                    delta as f32,
                ));
            }
            _ => {
                let to: [f64; 3] = places[0].translation.into();
                light.move_marker(Vec3::from(to.map(|x| x as f32)), looked_at);
            }
        }
        true
    }

    fn configure(
        &mut self,
        ui: &egui::Ui,
        rect: egui::Rect,
        camera: &Camera,
        modes: EnumSet<GizmoMode>,
    ) {
        let camera = camera.standard();
        let view = Mat4::from(camera.world_from_view.inverse()).as_dmat4();
        let projection = camera.clip_from_view.as_dmat4();
        let viewport = transform_gizmo::Rect {
            min: [rect.min.x, rect.min.y].into(),
            max: [rect.max.x, rect.max.y].into(),
        };
        self.gizmo.update_config(GizmoConfig {
            view_matrix: rows(&view),
            projection_matrix: rows(&projection),
            viewport,
            modes,
            orientation: GizmoOrientation::Global,
            pixels_per_point: ui.ctx().pixels_per_point(),
            ..*self.gizmo.config()
        });
    }

    fn draw(&self, ui: &egui::Ui, rect: egui::Rect) {
        let drawn = self.gizmo.draw();
        let corners = drawn.vertices.iter().zip(&drawn.colors);
        let vertices = corners.map(|(&[x, y], &[r, g, b, a])| egui::epaint::Vertex {
            pos: egui::pos2(x, y),
            uv: egui::epaint::WHITE_UV,
            color: egui::Rgba::from_rgba_premultiplied(r, g, b, a).into(),
        });
        ui.painter_at(rect).add(egui::Mesh {
            indices: drawn.indices,
            vertices: vertices.collect(),
            ..egui::Mesh::default()
        });
    }
}

fn rows(matrix: &DMat4) -> mint::RowMatrix4<f64> {
    let rows: [[f64; 4]; 4] = matrix.transpose().to_cols_array_2d();
    rows.into()
}
