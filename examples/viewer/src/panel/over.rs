//! Windows and labels over the image: descriptions of both sides, maps, lists, messages, keys.

use super::side;
use crate::{
    drops,
    keys::KEYS,
    picker::{Chosen, Picker},
    side::SIDES,
    viewer::{Viewer, is_narrow},
};
use egui::{Align2, Rect, Window};

/// Draws all windows and labels over the image.
pub(crate) fn show(viewer: &mut Viewer, ui: &egui::Ui) {
    let rect = ui.max_rect();
    let below = unfold(viewer, ui, rect);
    side::labels(viewer, ui, rect.with_min_y(rect.min.y + below));
    maps(viewer, ui);
    picker(viewer, ui);
    let held = ui.input(|input| input.raw.hovered_files.clone());
    let paths: Vec<_> = held.iter().map(|file| file.path.clone()).collect();
    if let Some(offer) = drops::offer(&paths) {
        notice(ui, "offer", Align2::CENTER_CENTER, 0.0, |ui| {
            ui.label(offer);
        });
    }
    // Put the message above the loading notice.
    let up = if show_loading(viewer, ui) {
        -64.0
    } else {
        -16.0
    };
    if let Some(message) = viewer.message.clone() {
        notice(ui, "message", Align2::CENTER_BOTTOM, up, |ui| {
            ui.set_max_width(0.7 * rect.width());
            ui.horizontal(|ui| {
                ui.label(message);
                if ui.button("Close").clicked() {
                    viewer.message = None;
                }
            });
        });
    }
    if viewer.settings.shows_help {
        help(viewer, ui);
    }
}

/// Returns the offset from an anchor of the window to that of the image, points.
fn offset(ui: &egui::Ui, y: f32) -> [f32; 2] {
    let window = ui.ctx().viewport_rect();
    [ui.max_rect().center().x - window.center().x, y]
}

/// Draws a small window without a title.
fn notice(ui: &egui::Ui, name: &str, align: Align2, y: f32, contents: impl FnOnce(&mut egui::Ui)) {
    Window::new(name)
        .title_bar(false)
        .resizable(false)
        .anchor(align, offset(ui, y))
        .show(ui.ctx(), contents);
}

/// Draws the loading notice. Returns whether a scene is loading.
fn show_loading(viewer: &mut Viewer, ui: &egui::Ui) -> bool {
    let Some(loading) = &viewer.loading else {
        return false;
    };
    let label = loading.label();
    notice(ui, "loading", Align2::CENTER_BOTTOM, -16.0, |ui| {
        ui.horizontal(|ui| {
            ui.label(label);
            let cancel = ui.button("Cancel loading");
            if cancel.on_hover_text("Esc").clicked() {
                viewer.cancel_loading();
            }
        });
    });
    true
}

/// Draws the window with the maps of both sides, which are drawn at rest.
fn maps(viewer: &mut Viewer, ui: &egui::Ui) {
    let mut is_open = viewer.settings.shows_maps;
    Window::new("Maps")
        .open(&mut is_open)
        .default_pos([340.0, 60.0])
        .show(ui.ctx(), |ui| {
            for (i, name) in SIDES.iter().enumerate() {
                if viewer.pace.rests() {
                    let subject = viewer.subject();
                    let settings = &viewer.settings.sides[i];
                    let updated = viewer.maps[i].update(ui.ctx(), subject, settings);
                    viewer.check(updated);
                }
                let maps = &viewer.maps[i];
                ui.label(format!("{name}: {}", maps.label));
                if let Some(texture) = &maps.shown {
                    ui.image(egui::load::SizedTexture::from_handle(texture));
                }
            }
        });
    viewer.settings.shows_maps = is_open;
}

/// Draws the window with all keys.
fn help(viewer: &mut Viewer, ui: &egui::Ui) {
    let is_narrow = is_narrow(ui.ctx());
    let keys = |ui: &mut egui::Ui| {
        if is_narrow {
            for (keys, what, _) in &KEYS {
                ui.horizontal_wrapped(|ui| {
                    ui.strong(*keys);
                    ui.label(*what);
                });
            }
            return;
        }
        egui::Grid::new("keys")
            .num_columns(4)
            .striped(true)
            .show(ui, |ui| {
                // Use two columns, so that the lines fit small windows.
                for lines in KEYS.chunks(2) {
                    for (keys, what, _) in lines {
                        ui.strong(*keys);
                        ui.label(*what);
                    }
                    ui.end_row();
                }
            });
    };
    Window::new("Keys")
        .open(&mut viewer.settings.shows_help)
        .resizable(false)
        .vscroll(is_narrow)
        .anchor(Align2::CENTER_CENTER, offset(ui, 0.0))
        .show(ui.ctx(), keys);
}

/// Draws the button that unfolds a folded panel. Returns its height with a margin, points, or 0
/// without a button.
fn unfold(viewer: &mut Viewer, ui: &egui::Ui, rect: Rect) -> f32 {
    if !viewer.is_folded(ui.ctx()) {
        return 0.0;
    }
    let area = egui::Area::new(egui::Id::unique("unfold"))
        .fixed_pos(rect.left_top() + egui::vec2(8.0, 8.0))
        .show(ui.ctx(), |ui| {
            // Large enough for fingers.
            let words = egui::RichText::new("\u{2630} Scene and settings").size(16.0);
            let button = egui::Button::new(words).min_size(egui::vec2(44.0, 40.0));
            if ui
                .add(button)
                .on_hover_text("Unfolds the panel (F4)")
                .clicked()
            {
                viewer.fold(ui.ctx());
            }
        });
    area.response.rect.height() + 8.0
}

/// Draws the list of the picker, if it is open.
fn picker(viewer: &mut Viewer, ui: &egui::Ui) {
    let Some(mut picker) = viewer.picker.take() else {
        return;
    };
    let mut chosen = None;
    let mut is_open = true;
    Window::new(picker.title())
        .id(egui::Id::unique("picker"))
        .open(&mut is_open)
        .resizable(false)
        .collapsible(false)
        .anchor(Align2::CENTER_TOP, offset(ui, 40.0))
        .show(ui.ctx(), |ui| {
            let window = ui.ctx().viewport_rect().width();
            ui.set_width((window - 32.0).min(430.0));
            chosen = contents(&mut picker, ui);
        });
    match chosen {
        Some(chosen) => viewer.show_chosen(ui.ctx(), chosen),
        None if is_open => viewer.picker = Some(picker),
        None => {}
    }
}

/// Draws the typed text and the lines. Returns the choice if a line was clicked.
fn contents(picker: &mut Picker, ui: &mut egui::Ui) -> Option<Chosen> {
    let mut chosen = None;
    egui::Frame::canvas(ui.style()).show(ui, |ui| {
        ui.set_width(ui.available_width());
        if picker.typed.is_empty() {
            ui.weak("type part of the name or description; Enter opens, Esc closes");
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
                    chosen = Some(line.chosen.clone());
                }
            }
            if lines.is_empty() {
                ui.weak("no matches");
            }
        });
    picker.has_moved = false;
    if let Some(line) = lines.get(picker.at) {
        ui.weak(&line.summary);
    }
    chosen
}
