//! List of the lights, and settings of the selected one.

use crate::{
    lights::{EditLight, LightKind, MAX_LIGHTS},
    viewer::Viewer,
};
use umbrage::{Aabb, Light, glam::Vec3};

/// Draws the list of lights and the settings of the selected one.
pub(crate) fn show(viewer: &mut Viewer, ui: &mut egui::Ui) {
    ui.separator();
    let bounds = viewer.stage.bounds;
    let settings = &mut viewer.settings;
    ui.horizontal(|ui| {
        ui.label("Lights");
        let has_capacity = settings.lights.len() < MAX_LIGHTS;
        if ui
            .add_enabled(has_capacity, egui::Button::new("Add"))
            .clicked()
        {
            settings.add_light(&bounds);
        }
        let is_there = settings.chosen < settings.lights.len();
        if ui
            .add_enabled(is_there, egui::Button::new("Remove"))
            .clicked()
        {
            settings.remove_light();
        }
    });
    ui.horizontal_wrapped(|ui| {
        for (i, light) in settings.lights.iter().enumerate() {
            let label = format!("{} {}", i + 1, LightKind::of_light(&light.light).name());
            if ui.selectable_label(i == settings.chosen, label).clicked() {
                settings.chosen = i;
            }
        }
    });
    if let Some(light) = settings.lights.get_mut(settings.chosen) {
        ui.push_id(settings.chosen, |ui| show_chosen(ui, light, &bounds));
    }
}

fn show_chosen(ui: &mut egui::Ui, light: &mut EditLight, bounds: &Aabb) {
    ui.horizontal(|ui| {
        ui.checkbox(&mut light.is_on, "on");
        ui.color_edit_button_rgb(&mut light.color);
        let drag = egui::DragValue::new(&mut light.brightness)
            .range(0.0..=20.0)
            .speed(0.01);
        ui.add(drag).on_hover_text("Brightness");
        let mut kind = LightKind::of_light(&light.light);
        egui::ComboBox::from_id_salt("kind")
            .selected_text(kind.name())
            .show_ui(ui, |ui| {
                for other in LightKind::ALL {
                    ui.selectable_value(&mut kind, other, other.name());
                }
            });
        light.retype(kind, bounds);
    });
    projection(ui, light, bounds);
    match &mut light.light {
        Light::Directional {
            direction,
            angular_diameter,
        } => {
            vector(ui, direction, "direction");
            if direction.length() < 1e-6 {
                *direction = Vec3::NEG_Y;
            }
            degrees(
                ui,
                angular_diameter,
                0.0..=60.0,
                "angular diameter (Sun: 0.53)",
            );
        }
        Light::Spot {
            position,
            direction,
            inner,
            outer,
            radius,
        } => {
            vector(ui, position, "position");
            vector(ui, direction, "direction");
            if direction.length() < 1e-6 {
                *direction = Vec3::NEG_Y;
            }
            degrees(ui, outer, 1.0..=85.0, "half angle");
            degrees(ui, inner, 0.0..=85.0, "of full light");
            *inner = inner.min(*outer);
            metres(ui, radius, 0.0, "radius");
        }
        Light::Point { position, radius } => {
            vector(ui, position, "position");
            metres(ui, radius, 0.0, "radius");
        }
        Light::Rect {
            center,
            half_u,
            half_v,
        } => {
            vector(ui, center, "centre");
            for (half, name) in [(half_u, "half width"), (half_v, "half height")] {
                let mut length = half.length();
                metres(ui, &mut length, 1e-3, name);
                *half = half.normalize_or(Vec3::X) * length;
            }
        }
        Light::Disc {
            center,
            normal,
            radius,
        } => {
            vector(ui, center, "centre");
            vector(ui, normal, "normal");
            if normal.length() < 1e-6 {
                *normal = Vec3::NEG_Y;
            }
            metres(ui, radius, 1e-3, "radius");
        }
    }
}

/// Draws the choice of projection. The map of a directional light is orthographic, that of a
/// distant spot light has perspective.
fn projection(ui: &mut egui::Ui, light: &mut EditLight, bounds: &Aabb) {
    let has_perspective = match LightKind::of_light(&light.light) {
        LightKind::Directional => false,
        LightKind::Spot => true,
        _ => return,
    };
    ui.horizontal(|ui| {
        ui.label("map");
        if ui.radio(!has_perspective, "orthographic").clicked() && has_perspective {
            light.set_perspective(false, bounds);
        }
        if ui.radio(has_perspective, "perspective").clicked() && !has_perspective {
            light.set_perspective(true, bounds);
        }
    });
}

fn vector(ui: &mut egui::Ui, vector: &mut Vec3, name: &str) {
    ui.horizontal(|ui| {
        for component in vector.as_mut() {
            ui.add(
                egui::DragValue::new(component)
                    .range(-1e6..=1e6)
                    .speed(0.02)
                    .max_decimals(2),
            );
        }
        ui.label(name);
    });
}

fn degrees(ui: &mut egui::Ui, angle: &mut f32, range: std::ops::RangeInclusive<f32>, name: &str) {
    let mut shown = angle.to_degrees();
    let slider = egui::Slider::new(&mut shown, range)
        .suffix("°")
        .max_decimals(2)
        .text(name);
    if ui.add(slider).changed() {
        *angle = shown.to_radians();
    }
}

fn metres(ui: &mut egui::Ui, length: &mut f32, least: f32, name: &str) {
    ui.horizontal(|ui| {
        let drag = egui::DragValue::new(length)
            .range(least..=1e4)
            .speed(0.01)
            .suffix(" m")
            .max_decimals(3);
        ui.add(drag);
        ui.label(name);
    });
}
