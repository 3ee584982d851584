//! The panel: settings to change, and what the set reports.

use crate::{
    renderer::{Renderer, Times},
    settings::Settings,
};
use std::time::Duration;
use umbrage::{
    Camera,
    techniques::{self, Bias, TechniquePreset},
};

/// Points.
const WIDTH: f32 = 250.0;

/// What the last frames took.
#[derive(Clone, Copy, Default)]
pub struct Figures {
    pub times: Times,
    /// From the begin of a frame to that of the next.
    pub frame: Duration,
}

impl Figures {
    /// Takes the next frame, so that the figures change slowly enough to be read.
    pub fn add(&mut self, next: Figures) {
        let blend = |old: Duration, new: Duration| old.mul_f32(0.8) + new.mul_f32(0.2);
        if self.frame.is_zero() {
            *self = next;
        }
        self.times.prepare = blend(self.times.prepare, next.times.prepare);
        self.times.encode = blend(self.times.encode, next.times.encode);
        self.frame = blend(self.frame, next.frame);
    }
}

/// Draws the panel and lets it change the settings. `speed` is the camera's, metres a second.
pub fn show(
    ui: &egui::Ui,
    settings: &mut Settings,
    renderer: &Renderer,
    camera: &Camera,
    speed: f32,
    figures: &Figures,
) {
    egui::Window::new("Shadows")
        .fixed_pos([10.0, 10.0])
        .resizable(false)
        .default_size([WIDTH, 600.0])
        .max_height(ui.available_height() - 60.0)
        .vscroll(true)
        .show(ui.ctx(), |ui| {
            ui.set_max_width(WIDTH);
            pasted(ui, settings);
            technique(ui, settings, renderer, camera);
            if settings.preset.map().is_some() {
                maps(ui, settings);
                bias(ui, &mut settings.bias);
            }
            ui.separator();
            ui.label("Projection of the sun");
            ui.horizontal(|ui| {
                ui.radio_value(&mut settings.sun_perspective, false, "orthographic");
                ui.radio_value(&mut settings.sun_perspective, true, "perspective");
            });
            ui.horizontal(|ui| {
                ui.checkbox(&mut settings.deferred, "deferred");
                ui.checkbox(&mut settings.moving, "things move");
            });
            ui.label(format!("flies {speed:.1} m/s (mouse wheel)"));
            ui.label("Ctrl+V takes a copied preset");
            ui.separator();
            report(ui, renderer, figures);
        });
}

/// Takes a preset from the clipboard, and says why where it is none.
fn pasted(ui: &mut egui::Ui, settings: &mut Settings) {
    let message = egui::Id::unique("what is wrong with what was pasted");
    for event in ui.input(|input| input.events.clone()) {
        if let egui::Event::Paste(text) = event {
            let wrong = settings.paste(&text).err().map(|error| error.to_string());
            ui.data_mut(|data| data.insert_temp(message, wrong));
        }
    }
    let wrong: Option<String> = ui.data(|data| data.get_temp(message)).flatten();
    if let Some(wrong) = wrong {
        ui.colored_label(ui.visuals().error_fg_color, wrong);
    }
}

fn technique(ui: &mut egui::Ui, settings: &mut Settings, renderer: &Renderer, camera: &Camera) {
    let name = settings.preset.technique().name();
    egui::ComboBox::from_label("technique")
        .selected_text(name)
        .height(400.0)
        .show_ui(ui, |ui| {
            for entry in techniques::all() {
                let refusal = renderer.shadows.refusal(entry, camera);
                let item = egui::Button::selectable(entry.name == name, entry.name);
                let response = ui.add_enabled(refusal.is_none(), item);
                if response.clicked() {
                    settings.choose(entry);
                }
                response
                    .on_hover_text(entry.summary)
                    .on_disabled_hover_text(refusal.unwrap_or_default());
            }
        });
    if let Some(preset) = own_numbers(ui, &settings.preset) {
        settings.preset = preset;
    }
}

/// Shows the numbers that a technique has beside its map, whatever it is: its settings are plain data. Returns it with those that the
/// user changed.
fn own_numbers(ui: &mut egui::Ui, preset: &TechniquePreset) -> Option<TechniquePreset> {
    let mut table: toml::Table = preset.to_toml().ok()?.parse().ok()?;
    let mut changed = false;
    for (name, value) in &mut table {
        let name = name.replace('_', " ");
        let response = match value {
            toml::Value::Integer(number) => {
                let slider = egui::DragValue::new(number).range(0..=64).speed(0.1);
                ui.horizontal(|ui| (ui.add(slider), ui.label(name)).0).inner
            }
            toml::Value::Float(number) => {
                let slider = egui::DragValue::new(number).range(0.0..=64.0).speed(0.02);
                ui.horizontal(|ui| (ui.add(slider), ui.label(name)).0).inner
            }
            toml::Value::Boolean(is_on) => ui.checkbox(is_on, name),
            _ => continue,
        };
        changed |= response.changed();
    }
    if !changed {
        return None;
    }
    TechniquePreset::from_toml(&toml::to_string(&table).ok()?).ok()
}

fn maps(ui: &mut egui::Ui, settings: &mut Settings) {
    egui::ComboBox::from_label("side of the maps, texels")
        .selected_text(settings.map_size.to_string())
        .show_ui(ui, |ui| {
            for size in [256, 512, 1024, 2048, 4096] {
                ui.selectable_value(&mut settings.map_size, size, size.to_string());
            }
        });
    let slider = egui::Slider::new(&mut settings.cascades, 1..=8).text("cascades");
    ui.add_enabled(!settings.sun_perspective, slider);
}

fn bias(ui: &mut egui::Ui, bias: &mut Bias) {
    let known = Bias::PRESETS.iter().find(|(_, preset)| preset == bias);
    egui::ComboBox::from_label("bias")
        .selected_text(known.map_or("by hand", |(name, _)| name))
        .show_ui(ui, |ui| {
            for (name, preset) in Bias::PRESETS {
                ui.selectable_value(bias, preset, name);
            }
        });
    for (name, number, speed) in [
        ("constant, clip depth", &mut bias.constant, 0.0001),
        ("slope, clip depth", &mut bias.slope, 0.001),
        ("normal offset, texels", &mut bias.normal_offset, 0.02),
    ] {
        ui.horizontal(|ui| {
            let range = 0.0..=8.0;
            ui.add(egui::DragValue::new(number).range(range).speed(speed));
            ui.label(name);
        });
    }
}

fn report(ui: &mut egui::Ui, renderer: &Renderer, figures: &Figures) {
    let set = &renderer.shadows.set;
    let report = set.report();
    let unserved = renderer.shadows.unserved();
    let milliseconds = |d: Duration| format!("{:.2} ms", 1000.0 * d.as_secs_f64());
    let mebibytes = |bytes: u64| format!("{:.2} MiB", bytes as f64 / f64::from(1 << 20));
    let count: usize = unserved.iter().map(|(_, lights)| lights).sum();
    let rows = [
        ("prepare", milliseconds(figures.times.prepare)),
        ("encode", milliseconds(figures.times.encode)),
        ("frame", milliseconds(figures.frame)),
        ("layers redrawn", report.redrawn.to_string()),
        ("layers that wait", report.waiting.to_string()),
        ("uploaded", format!("{} bytes", report.uploaded)),
        ("maps", mebibytes(set.map_bytes())),
        ("casters", set.caster_count().to_string()),
        ("lights", renderer.shadows.lights.len().to_string()),
        ("without shadows", count.to_string()),
    ];
    egui::Grid::new("report").num_columns(2).show(ui, |ui| {
        for (name, value) in rows {
            ui.label(name);
            ui.monospace(value);
            ui.end_row();
        }
    });
    for (reason, lights) in unserved {
        ui.label(format!("{lights} lights: {reason}"));
    }
}
