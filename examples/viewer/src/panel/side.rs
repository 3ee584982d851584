//! Settings of a side, generated from the list of techniques.

use super::plain;
use crate::{
    side::{FitKind, SIDES, SideSettings},
    viewer::Viewer,
};
use umbrage::{
    Cascades, Layout,
    techniques::{self, Bias, ShadowMap},
};

/// Draws a side's settings.
pub(crate) fn show(viewer: &mut Viewer, ui: &mut egui::Ui, side: usize) {
    ui.separator();
    let before = viewer.settings.sides[side].clone();
    let title = format!("{}: {}", SIDES[side], before.preset.technique().name());
    egui::CollapsingHeader::new(title)
        .id_salt(("side", side))
        .default_open(true)
        .show(ui, |ui| {
            ui.push_id(side, |ui| {
                settings(ui, &mut viewer.settings.sides[side]);
            });
            for refusal in viewer.renderer.sides[side].refusals() {
                ui.colored_label(egui::Color32::from_rgb(255, 170, 80), refusal);
            }
            ui.horizontal(|ui| {
                if ui.button("Copy preset").clicked() {
                    viewer.copy_preset(ui.ctx(), side);
                }
                if ui.button("Same as the other").clicked() {
                    viewer.settings.sides[side] = viewer.settings.sides[1 - side].clone();
                }
            });
        });
    if viewer.settings.sides[side] != before {
        viewer.forget_side(side);
    }
}

fn settings(ui: &mut egui::Ui, settings: &mut SideSettings) {
    let name = settings.preset.technique().name();
    egui::ComboBox::from_label("technique")
        .selected_text(name)
        .height(500.0)
        .show_ui(ui, |ui| {
            for entry in techniques::all() {
                let item = ui.selectable_label(entry.name == name, entry.name);
                if item.on_hover_text(entry.summary).clicked() && entry.name != name {
                    settings.choose(entry);
                }
            }
        });
    if let Some(preset) = plain::own(ui, &settings.preset) {
        settings.preset = preset;
    }
    if let Some(map) = settings.preset.map().copied() {
        let changed = map_settings(ui, settings, map);
        if changed != map {
            settings.preset = settings.preset.with_map(changed);
        }
        let rest = egui::CollapsingHeader::new("all of the map").show(ui, |ui| {
            ui.weak("Settings that are not in the lists above.");
            plain::of_map(ui, &settings.preset)
        });
        if let Some(preset) = rest.body_returned.flatten() {
            settings.preset = preset;
        }
    }
}

pub(super) fn labelled_drag(ui: &mut egui::Ui, drag: egui::DragValue<'_>, label: &str) -> bool {
    ui.horizontal(|ui| {
        // Ranges only limit dragging. Keep values of a preset outside them.
        let response = ui.add(drag.clamp_existing_to_range(false));
        ui.label(label);
        response.changed()
    })
    .inner
}

fn map_settings(ui: &mut egui::Ui, settings: &mut SideSettings, mut map: ShadowMap) -> ShadowMap {
    egui::ComboBox::from_label("side of the map, texels")
        .selected_text(map.size.to_string())
        .show_ui(ui, |ui| {
            for size in [128, 256, 512, 1024, 2048, 4096, 8192] {
                ui.selectable_value(&mut map.size, size, size.to_string());
            }
        });
    egui::ComboBox::from_label("fit")
        .selected_text(settings.fit.name())
        .show_ui(ui, |ui| {
            for fit in FitKind::ALL {
                ui.selectable_value(&mut settings.fit, fit, fit.name());
            }
        });
    if matches!(settings.fit, FitKind::Stable | FitKind::AroundCamera) {
        let drag = egui::DragValue::new(&mut settings.range)
            .range(0.1..=1e6)
            .speed(0.5)
            .suffix(" m");
        labelled_drag(ui, drag, "range");
    }
    let slider = egui::Slider::new(&mut settings.cascades, 1..=8).text("cascades (directional)");
    if ui.add(slider).changed() {
        map.layout = layout(settings.cascades, map.layout);
    }
    bias(ui, &mut map.bias);
    map
}

/// Returns the layout with this number of maps of a directional light. The other settings are kept,
/// and are shown with the rest of the map.
fn layout(maps: u32, before: Layout) -> Layout {
    let known = match before {
        Layout::Cascades(cascades) => Some(cascades),
        _ => None,
    };
    match known {
        _ if maps > 1 => Layout::Cascades(Cascades {
            count: maps,
            ..known.unwrap_or_default()
        }),
        Some(_) => Layout::Auto,
        None => before,
    }
}

fn bias(ui: &mut egui::Ui, bias: &mut Bias) {
    let known = Bias::PRESETS.iter().find(|(_, preset)| preset == bias);
    egui::ComboBox::from_label("bias")
        .selected_text(known.map_or("by hand", |(name, _)| name))
        .height(400.0)
        .show_ui(ui, |ui| {
            for (name, preset) in Bias::PRESETS {
                ui.selectable_value(bias, preset, name);
            }
        });
    egui::CollapsingHeader::new("manual bias").show(ui, |ui| {
        for (name, number, speed) in [
            ("constant, clip depth", &mut bias.constant, 1e-4),
            ("slope, clip depth", &mut bias.slope, 1e-3),
            ("normal offset, texels", &mut bias.normal_offset, 0.02),
        ] {
            let drag = egui::DragValue::new(number)
                .range(0.0..=8.0)
                .speed(speed)
                .max_decimals(5);
            labelled_drag(ui, drag, name);
        }
    });
}

/// Width below which labels over the image are omitted, points.
const NARROWEST: f32 = 80.0;

/// Draws a text of at most this width, points.
fn draw_wrapped_text(
    painter: &egui::Painter,
    corner: egui::Pos2,
    anchor: egui::Align2,
    text: &str,
    color: egui::Color32,
    most: f32,
) {
    let font = egui::FontId::proportional(15.0);
    let mut job = egui::text::LayoutJob::simple(text.to_owned(), font, color, most);
    job.halign = anchor.x();
    let galley = painter.layout_job(job);
    // Galleys are positioned relative to their alignment.
    painter.galley(corner, galley, color);
}

/// Draws labels over the image with the technique and the error of each side.
pub(crate) fn labels(viewer: &Viewer, ui: &egui::Ui, rect: egui::Rect) {
    let painter = ui.painter_at(rect);
    let shown: &[usize] = match viewer.settings.split {
        Some(_) => &[0, 1],
        None if viewer.settings.shown_side == 0 => &[0],
        None => &[1],
    };
    // Limit each side to its half of the image.
    let most = rect.width() / shown.len() as f32 - 16.0;
    if most < NARROWEST {
        return;
    }
    for &side in shown {
        let (corner, anchor) = if side == 0 {
            (
                rect.left_top() + egui::vec2(10.0, 8.0),
                egui::Align2::LEFT_TOP,
            )
        } else {
            (
                rect.right_top() + egui::vec2(-10.0, 8.0),
                egui::Align2::RIGHT_TOP,
            )
        };
        let mut text = viewer.settings.sides[side].label();
        let figures = &viewer.figures.sides[side];
        if let Some(refusal) = &figures.refusal {
            text += &format!("\nno shadows: {refusal}");
        } else if let Some(error) = figures.error.filter(|error| error.pixels == 0) {
            text += match error.ambiguous {
                Some(_) => "\nnothing to compare: the light reaches no pixel",
                None => "\nnot yet compared",
            };
        } else if let Some(error) = figures.error {
            text += &match error.rmse {
                0.0 => "\nexact".to_owned(),
                // A percentage of so few pixels would have no meaning.
                rmse if error.wrong < 100 => format!(
                    "\nRMSE {rmse:.4}, {} of {} pixels wrong",
                    error.wrong, error.pixels
                ),
                rmse => {
                    let percent = 100.0 * error.wrong as f64 / error.pixels as f64;
                    format!("\nRMSE {rmse:.4}, {percent:.2} % wrong")
                }
            };
            if error.ambiguous.is_none() {
                // Pixels whose reference depends on rounding still count as wrong.
                text += "\npreliminary: the reference is not yet checked";
            }
            if let Some(ambiguous) = error.ambiguous.filter(|&ambiguous| ambiguous > 0) {
                text += &format!("\n{ambiguous} ambiguous pixels excluded");
            }
        }
        // Draw a shadow of the text, for legibility on any image.
        let black = egui::Color32::BLACK;
        for offset in [
            egui::vec2(1.0, 1.0),
            egui::vec2(-1.0, 1.0),
            egui::vec2(1.0, -1.0),
        ] {
            draw_wrapped_text(&painter, corner + offset, anchor, &text, black, most);
        }
        draw_wrapped_text(&painter, corner, anchor, &text, egui::Color32::WHITE, most);
    }
}
