//! The panel beside the picture, and what stands over it.

mod chart;
mod lights;
pub(crate) mod maps;
pub(crate) mod picker;
mod plain;
mod side;

use crate::render::SIDES;
use crate::{
    app::App,
    bookmarks,
    camera::Mode,
    drops,
    focus::Focus,
    keys::KEYS,
    loading::Then,
    measure::figures::Picture,
    measure::places::{HEAT_NANOSECONDS, LIST_LENGTHS},
};
use umbrage::scenes;

/// Colours of words that name a colour, light enough for a dark panel.
const BLUE: egui::Color32 = egui::Color32::from_rgb(100, 150, 255);
const RED: egui::Color32 = egui::Color32::from_rgb(255, 90, 70);

/// The panel's width until the user drags its edge, and the least, points: its longest lines fit, so that no text moves the edge.
const WIDTH: f32 = 346.0;
/// Windows less wide than this begin with the panel folded, since it would cover the picture: pixels divided by the display's scale
/// factor.
const NARROW: f32 = 700.0;

/// Whether the panel is folded. Until the user says so, that goes with the window's width.
fn is_folded(app: &App, ctx: &egui::Context) -> bool {
    app.settings
        .panel_is_folded
        .unwrap_or_else(|| is_narrow(ctx))
}

fn is_narrow(ctx: &egui::Context) -> bool {
    ctx.viewport_rect().width() * ctx.zoom_factor() < NARROW
}

/// Folds the panel, or unfolds it.
pub(crate) fn fold(app: &mut App, ctx: &egui::Context) {
    app.settings.panel_is_folded = Some(!is_folded(app, ctx));
}

/// Returns how far the middle of the picture is right of the window's, points.
fn beside(picture: egui::Rect, ctx: &egui::Context) -> f32 {
    picture.center().x - ctx.viewport_rect().center().x
}

/// Draws the panel, unless it is folded.
pub(crate) fn show(app: &mut App, ui: &mut egui::Ui) {
    if is_folded(app, ui.ctx()) {
        return;
    }
    // The window's background, which costs nothing, is the panel's: see `App::clear_color`.
    let frame = egui::Frame::side_top_panel(ui.style()).fill(egui::Color32::TRANSPARENT);
    let panel = egui::Panel::left("panel")
        .frame(frame)
        .default_size(WIDTH)
        .size_range(WIDTH..=520.0)
        .show(ui, |ui| {
            egui::ScrollArea::vertical()
                .auto_shrink(false)
                .show(ui, |ui| {
                    scene(app, ui);
                    view(app, ui);
                    for i in 0..2 {
                        side::show(app, ui, i);
                    }
                    lights::show(app, ui);
                    chart::show(app, ui);
                    figures(app, ui);
                    app.focus.scroll(ui);
                });
        });
    Focus::draw(ui.ctx(), ui.layer_id(), panel.response.rect);
}

fn scene(app: &mut App, ui: &mut egui::Ui) {
    ui.add_space(4.0);
    let mut wanted = None;
    ui.horizontal(|ui| {
        ui.label("Scene");
        egui::ComboBox::from_id_salt("scene")
            .selected_text(&app.stage.name)
            .width(140.0)
            .height(500.0)
            .show_ui(ui, |ui| {
                for entry in scenes::all() {
                    let item = ui.selectable_label(entry.name == app.stage.argument, entry.name);
                    if item.on_hover_text(entry.summary).clicked() {
                        wanted = Some(entry.name);
                    }
                }
            });
        failures(app, ui);
        if ui
            .button("Fold")
            .on_hover_text("Folds the panel (F4)")
            .clicked()
        {
            fold(app, ui.ctx());
        }
        if ui.button("?").on_hover_text("All keys (F1)").clicked() {
            app.settings.shows_help = !app.settings.shows_help;
        }
    });
    let triangles = app.stage.geometry.triangles().len();
    ui.weak(format!(
        "{triangles} triangles; drop a .toml, .obj, .glb or .gltf file here, with what it names, for another scene"
    ));
    if let Some(path) = &mut app.path {
        ui.horizontal(|ui| {
            let words = if path.is_playing { "Pause" } else { "Play" };
            if ui.button(words).on_hover_text("Space").clicked() {
                path.is_playing = !path.is_playing;
            }
            ui.label(path.moving.motion.label());
        });
    }
    if let Some(name) = wanted {
        app.open(ui.ctx(), name, Then::Show);
    }
}

/// A menu of places where shadow methods fail.
fn failures(app: &mut App, ui: &mut egui::Ui) {
    ui.menu_button("Failures", |ui| {
        ui.weak("left shows the fault, right the cure; F flips");
        egui::ScrollArea::vertical()
            .max_height(500.0)
            .show(ui, |ui| {
                for bookmark in bookmarks::all() {
                    let button = ui.button(bookmark.label());
                    if button.on_hover_text(bookmark.description()).clicked() {
                        app.open(ui.ctx(), bookmark.scene, Then::Compare(bookmark));
                        ui.close();
                    }
                }
            });
    });
}

fn view(app: &mut App, ui: &mut egui::Ui) {
    let mut takes_screenshot = false;
    let settings = &mut app.settings;
    ui.horizontal(|ui| {
        ui.selectable_value(&mut settings.view.mode, Mode::Fly, "fly");
        ui.selectable_value(&mut settings.view.mode, Mode::Orbit, "orbit");
        ui.checkbox(&mut settings.view.orthographic, "parallel");
        let speed = egui::DragValue::new(&mut settings.view.speed)
            .range(0.01..=1000.0)
            .speed(0.1)
            .suffix(" m/s");
        ui.add(speed).on_hover_text("How fast W A S D fly");
        // Browsers have their own.
        let has_folders = cfg!(not(target_arch = "wasm32"));
        takes_screenshot = has_folders && ui.button("Screenshot").on_hover_text("F12").clicked();
    });
    let mut is_split = settings.split.is_some();
    ui.horizontal(|ui| {
        ui.label("Show");
        if ui.selectable_label(is_split, "both").clicked() {
            is_split = true;
        }
        for (i, name) in SIDES.iter().enumerate() {
            let is_shown = !is_split && settings.shown_side == i;
            if ui.selectable_label(is_shown, *name).clicked() {
                is_split = false;
                settings.shown_side = i;
            }
        }
        ui.weak("X, F");
        ui.checkbox(&mut settings.shows_maps, "maps")
            .on_hover_text("What the chosen light draws for each side (M)");
    });
    if is_split != settings.split.is_some() {
        settings.split = is_split.then_some(0.5);
    }
    let before = (settings.picture, settings.opacity);
    ui.horizontal_wrapped(|ui| {
        ui.label("Over it");
        for (picture, name) in Picture::ALL {
            ui.selectable_value(&mut settings.picture, *picture, *name);
        }
    });
    if settings.picture == Picture::Error {
        ui.horizontal(|ui| {
            ui.colored_label(RED, "red: too light");
            ui.colored_label(BLUE, "blue: too dark");
            ui.add(egui::Slider::new(&mut settings.opacity, 0.1..=1.0).show_value(false))
                .on_hover_text("Opacity");
        });
    }
    if settings.picture == Picture::Lists {
        ui.horizontal_wrapped(|ui| {
            let [white, red] = LIST_LENGTHS;
            ui.label("casters asked:");
            ui.colored_label(BLUE, "blue: none");
            ui.label(format!("white: {white}"));
            ui.colored_label(RED, format!("red: {red} or more"));
            ui.colored_label(
                egui::Color32::from_rgb(60, 190, 130),
                "green: one hides all",
            );
            ui.weak("nothing: no lists (other techniques than exact), or none asked");
        });
    }
    if settings.picture == Picture::Heat {
        ui.horizontal_wrapped(|ui| {
            let [blue, white, red] = HEAT_NANOSECONDS;
            ui.label("a pixel's lookup on one thread of the processor:");
            ui.colored_label(BLUE, format!("blue: {blue} ns"));
            ui.label(format!("white: {white} ns"));
            ui.colored_label(RED, format!("red: {red} ns or more"));
            ui.weak("timed in blocks once truth is traced");
        });
    }
    if before != (settings.picture, settings.opacity) {
        app.compare();
    }
    if takes_screenshot {
        app.ask_for_screenshot(ui.ctx());
    }
}

fn figures(app: &App, ui: &mut egui::Ui) {
    ui.separator();
    let milliseconds = |d: web_time::Duration| format!("{:.1} ms", 1000.0 * d.as_secs_f64());
    egui::Grid::new("figures").num_columns(2).show(ui, |ui| {
        let mut row = |name: &str, value: String| {
            ui.label(name);
            ui.monospace(value);
            ui.end_row();
        };
        row("frame to frame", milliseconds(app.times.interval));
        row("of it on the CPU", milliseconds(app.times.work));
        row(
            "pixels while moving",
            format!("{:.0} %", 100.0 * app.scale * app.scale),
        );
        for (i, name) in SIDES.iter().enumerate() {
            let report = app.renderer.sides[i].set.report();
            let mebibytes = app.renderer.sides[i].set.map_bytes() as f64 / f64::from(1 << 20);
            row(
                &format!("{name}: layers drawn"),
                format!("{} ({mebibytes:.1} MiB)", report.redrawn),
            );
        }
        for (pass, time) in app.renderer.pass_times() {
            row(pass, format!("{time:.2} ms"));
        }
        if let Some(truth) = &app.figures.truth {
            row("truth known", format!("{:.0} %", 100.0 * truth.progress));
        }
    });
}

/// Draws what stands over the picture: what each side shows, messages, the keys.
pub(crate) fn over_picture(app: &mut App, ui: &egui::Ui) {
    let rect = ui.max_rect();
    let below = unfold(app, ui, rect);
    side::labels(app, ui, rect.with_min_y(rect.min.y + below));
    maps::show(app, ui, app.rests());
    picker::show(app, ui);
    offer(ui);
    let is_loading = loading(app, ui);
    if let Some(message) = app.message.clone() {
        // Above what is being read.
        let up = if is_loading { -64.0 } else { -16.0 };
        egui::Window::new("message")
            .title_bar(false)
            .resizable(false)
            .anchor(egui::Align2::CENTER_BOTTOM, [beside(rect, ui.ctx()), up])
            .show(ui.ctx(), |ui| {
                ui.set_max_width(0.7 * rect.width());
                ui.horizontal(|ui| {
                    ui.label(message);
                    if ui.button("Close").clicked() {
                        app.message = None;
                    }
                });
            });
    }
    if app.settings.shows_help {
        help(app, ui);
    }
}

/// Says what would be shown of the files that are held over the window, if anything.
fn offer(ui: &egui::Ui) {
    let held = ui.input(|input| input.raw.hovered_files.clone());
    let paths: Vec<_> = held.iter().map(|file| file.path.clone()).collect();
    let Some(words) = drops::offer(&paths) else {
        return;
    };
    egui::Window::new("offer")
        .title_bar(false)
        .resizable(false)
        .anchor(
            egui::Align2::CENTER_CENTER,
            [beside(ui.max_rect(), ui.ctx()), 0.0],
        )
        .show(ui.ctx(), |ui| ui.label(words));
}

/// Shows the keys.
fn help(app: &mut App, ui: &egui::Ui) {
    let middle = beside(ui.max_rect(), ui.ctx());
    let is_narrow = is_narrow(ui.ctx());
    let keys = |ui: &mut egui::Ui| {
        if is_narrow {
            for line in &KEYS {
                ui.horizontal_wrapped(|ui| {
                    ui.strong(line.keys);
                    ui.label(line.what);
                });
            }
            return;
        }
        egui::Grid::new("keys")
            .num_columns(4)
            .striped(true)
            .show(ui, |ui| {
                // Two columns of lines, so that small windows hold them.
                for lines in KEYS.chunks(2) {
                    for line in lines {
                        ui.strong(line.keys);
                        ui.label(line.what);
                    }
                    ui.end_row();
                }
            });
    };
    egui::Window::new("Keys")
        .open(&mut app.settings.shows_help)
        .resizable(false)
        .vscroll(is_narrow)
        .anchor(egui::Align2::CENTER_CENTER, [middle, 0.0])
        .show(ui.ctx(), keys);
}

/// Draws the button that unfolds a folded panel. Returns its height with a margin, points; 0 while there is none.
fn unfold(app: &mut App, ui: &egui::Ui, rect: egui::Rect) -> f32 {
    if !is_folded(app, ui.ctx()) {
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
                fold(app, ui.ctx());
            }
        });
    area.response.rect.height() + 8.0
}

/// Says what is being read. Returns whether something is.
fn loading(app: &mut App, ui: &egui::Ui) -> bool {
    let Some(at) = app.loader.at() else {
        return false;
    };
    let middle = beside(ui.max_rect(), ui.ctx());
    egui::Window::new("loading")
        .title_bar(false)
        .resizable(false)
        .anchor(egui::Align2::CENTER_BOTTOM, [middle, -16.0])
        .show(ui.ctx(), |ui| {
            ui.horizontal(|ui| {
                ui.label(at);
                let cancel = ui.button("Cancel loading");
                if cancel.on_hover_text("Esc").clicked() {
                    app.give_up_loading();
                }
            });
        });
    true
}

/// Writes a screenshot. Returns where.
#[cfg(not(target_arch = "wasm32"))]
pub(crate) fn save_screenshot(image: &egui::ColorImage) -> anyhow::Result<String> {
    let seconds = std::time::SystemTime::now()
        .duration_since(std::time::UNIX_EPOCH)
        .map_or(0, |since| since.as_secs());
    let place = std::env::current_dir()?.join(format!("umbrage-{seconds}.png"));
    let [width, height] = image.size.map(|side| side as u32);
    let bytes = image.as_raw().to_vec();
    let image = image::RgbaImage::from_raw(width, height, bytes);
    let image = anyhow::Context::context(image, "the window gave a broken picture")?;
    image.save(&place)?;
    Ok(place.display().to_string())
}

/// Browsers have no folders; their own screenshots do.
#[cfg(target_arch = "wasm32")]
pub(crate) fn save_screenshot(_: &egui::ColorImage) -> anyhow::Result<String> {
    anyhow::bail!("take the browser's own screenshot")
}
