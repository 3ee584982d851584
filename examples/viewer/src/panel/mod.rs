//! The panel to the left of the image.

mod chart;
mod lights;
pub(crate) mod over;
mod plain;
mod side;

use crate::{
    bookmarks,
    camera::Mode,
    focus::Focus,
    loading::Then,
    measure::pictures::{HEAT_NANOSECONDS, LIST_LENGTHS, Picture},
    settings::Settings,
    side::SIDES,
    viewer::Viewer,
};
use egui::{ComboBox, ScrollArea};
use umbrage::scenes;

/// Colours of words that name a colour, bright enough for a dark panel.
const BLUE: egui::Color32 = egui::Color32::from_rgb(100, 150, 255);
const RED: egui::Color32 = egui::Color32::from_rgb(255, 90, 70);
const GREEN: egui::Color32 = egui::Color32::from_rgb(60, 190, 130);

/// Default and least width of the panel, points. Its longest lines fit, so that no text moves the
/// edge.
const WIDTH: f32 = 346.0;

/// Draws the panel, unless it is folded.
pub(crate) fn show(viewer: &mut Viewer, ui: &mut egui::Ui) {
    if viewer.is_folded(ui.ctx()) {
        return;
    }
    // Use the window's background, which costs no time, as that of the panel: see
    // `App::clear_color`.
    let frame = egui::Frame::side_top_panel(ui.style()).fill(egui::Color32::TRANSPARENT);
    let panel = egui::Panel::left("panel")
        .frame(frame)
        .default_size(WIDTH)
        .size_range(WIDTH..=520.0)
        .show(ui, |ui| {
            ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                scene(viewer, ui);
                view(viewer, ui);
                for i in 0..2 {
                    side::show(viewer, ui, i);
                }
                lights::show(viewer, ui);
                chart::show(viewer, ui);
                figures(viewer, ui);
                viewer.focus.scroll(ui);
            });
        });
    Focus::draw(ui.ctx(), ui.layer_id(), panel.response.rect);
}

fn scene(viewer: &mut Viewer, ui: &mut egui::Ui) {
    ui.add_space(4.0);
    let mut wanted = None;
    ui.horizontal(|ui| {
        ui.label("Scene");
        ComboBox::from_id_salt("scene")
            .selected_text(&viewer.stage.name)
            .width(140.0)
            .height(500.0)
            .show_ui(ui, |ui| {
                for entry in scenes::all() {
                    let item = ui.selectable_label(entry.name == viewer.stage.argument, entry.name);
                    if item.on_hover_text(entry.summary).clicked() {
                        wanted = Some(entry.name);
                    }
                }
            });
        failures(viewer, ui);
        if ui
            .button("Fold")
            .on_hover_text("Folds the panel (F4)")
            .clicked()
        {
            viewer.fold(ui.ctx());
        }
        if ui.button("?").on_hover_text("All keys (F1)").clicked() {
            viewer.settings.shows_help = !viewer.settings.shows_help;
        }
    });
    let triangles = viewer.stage.geometry.triangles().len();
    ui.weak(format!(
        "{triangles} triangles; to open a scene, drop a .toml, .obj, .glb or .gltf file with its textures here"
    ));
    if let Some(path) = &mut viewer.path {
        ui.horizontal(|ui| {
            let words = if path.is_running { "Pause" } else { "Play" };
            if ui.button(words).on_hover_text("Space").clicked() {
                path.is_running = !path.is_running;
            }
            ui.label(path.moving.motion.label());
        });
    }
    if let Some(name) = wanted {
        viewer.open(ui.ctx(), name, Then::Show);
    }
}

/// Draws a menu of failures of shadow methods.
fn failures(viewer: &mut Viewer, ui: &mut egui::Ui) {
    ui.menu_button("Failures", |ui| {
        ui.weak("left: artefact, right: fix; F switches sides");
        ScrollArea::vertical().max_height(500.0).show(ui, |ui| {
            for bookmark in bookmarks::all() {
                let button = ui.button(bookmark.label());
                if button.on_hover_text(bookmark.description()).clicked() {
                    viewer.open(ui.ctx(), bookmark.scene, Then::Compare(bookmark));
                    ui.close();
                }
            }
        });
    });
}

fn view(viewer: &mut Viewer, ui: &mut egui::Ui) {
    let settings = &mut viewer.settings;
    let mut takes_screenshot = false;
    ui.horizontal(|ui| {
        ui.selectable_value(&mut settings.view.mode, Mode::Fly, "fly");
        ui.selectable_value(&mut settings.view.mode, Mode::Orbit, "orbit");
        ui.checkbox(&mut settings.view.orthographic, "parallel");
        let speed = egui::DragValue::new(&mut settings.view.speed)
            .range(0.01..=1000.0)
            .speed(0.1)
            .suffix(" m/s");
        ui.add(speed).on_hover_text("Speed of W A S D");
        // Browsers have their own screenshots.
        let has_folders = cfg!(not(target_arch = "wasm32"));
        takes_screenshot = has_folders && ui.button("Screenshot").on_hover_text("F12").clicked();
    });
    ui.horizontal(|ui| {
        ui.label("Show");
        let is_split = settings.split.is_some();
        if ui.selectable_label(is_split, "both").clicked() && !is_split {
            settings.split = Some(0.5);
        }
        for (i, name) in SIDES.iter().enumerate() {
            let is_shown = !is_split && settings.shown_side == i;
            if ui.selectable_label(is_shown, *name).clicked() {
                settings.split = None;
                settings.shown_side = i;
            }
        }
        ui.weak("X, F");
        ui.checkbox(&mut settings.shows_maps, "maps")
            .on_hover_text("Maps of the selected light for each side (M)");
    });
    let before = (settings.picture, settings.opacity);
    ui.horizontal_wrapped(|ui| {
        ui.label("Overlay");
        for (picture, name) in Picture::ALL {
            ui.selectable_value(&mut settings.picture, *picture, *name);
        }
    });
    if matches!(
        settings.picture,
        Picture::Error | Picture::Lists | Picture::Heat
    ) {
        ui.horizontal_wrapped(|ui| legend(ui, settings));
    }
    if before != (settings.picture, settings.opacity) {
        viewer.compare(ui.ctx());
    }
    if takes_screenshot {
        viewer.request_screenshot(ui.ctx());
    }
}

/// Draws the legend of the overlay.
fn legend(ui: &mut egui::Ui, settings: &mut Settings) {
    match settings.picture {
        Picture::Error => {
            ui.colored_label(RED, "red: too light");
            ui.colored_label(BLUE, "blue: too dark");
            let mut opacity = settings.opacity();
            let slider = egui::Slider::new(&mut opacity, 0.1..=1.0).show_value(false);
            if ui.add(slider).on_hover_text("Opacity").changed() {
                settings.opacity = Some(opacity);
            }
        }
        Picture::Lists => {
            let [white, red] = LIST_LENGTHS;
            ui.label("tested casters:");
            ui.colored_label(BLUE, "blue: none");
            ui.label(format!("white: {white}"));
            ui.colored_label(RED, format!("red: {red} or more"));
            ui.colored_label(GREEN, "green: one covers the cell");
            ui.weak("no colour: no lists (only exact has some), or no test");
        }
        Picture::Heat => {
            let [blue, white, red] = HEAT_NANOSECONDS;
            ui.label("lookup of a pixel on one CPU thread:");
            ui.colored_label(BLUE, format!("blue: {blue} ns"));
            ui.label(format!("white: {white} ns"));
            ui.colored_label(RED, format!("red: {red} ns or more"));
            ui.weak("timed in blocks after the reference is traced");
        }
        _ => {}
    }
}

fn figures(viewer: &Viewer, ui: &mut egui::Ui) {
    ui.separator();
    let milliseconds = |d: web_time::Duration| format!("{:.1} ms", 1000.0 * d.as_secs_f64());
    let pace = &viewer.pace;
    egui::Grid::new("figures").num_columns(2).show(ui, |ui| {
        let mut row = |name: &str, value: String| {
            ui.label(name);
            ui.monospace(value);
            ui.end_row();
        };
        row("frame interval", milliseconds(pace.interval));
        row("CPU time", milliseconds(pace.work));
        let percent = 100.0 * pace.scale * pace.scale;
        row("pixels in motion", format!("{percent:.0} %"));
        for (side, name) in viewer.renderer.sides.iter().zip(SIDES) {
            let redrawn = side.set.report().redrawn;
            let mebibytes = side.set.map_bytes() as f64 / f64::from(1 << 20);
            let value = format!("{redrawn} ({mebibytes:.1} MiB)");
            row(&format!("{name}: layers drawn"), value);
        }
        let times = viewer.renderer.clock.iter().flat_map(|clock| &clock.times);
        for (pass, time) in times {
            row(pass, format!("{time:.2} ms"));
        }
        if let Some(truth) = &viewer.figures.truth {
            row(
                "reference traced",
                format!("{:.0} %", 100.0 * truth.progress),
            );
        }
    });
}
