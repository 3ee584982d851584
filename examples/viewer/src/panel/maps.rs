//! A window with the maps of both sides, as the light draws them.

use crate::{
    app::App, beside::Beside, measure::planned_view, render::SIDES, settings::SideSettings,
};
use anyhow::Result;
use umbrage::{Aabb, Backend as _, Camera, Geometry, Light, Receivers, cpu::Cpu, glam::UVec2};

/// Pixels of a shown layer's side, at most.
const SHOWN_SIDE: u32 = 384;

/// What a picture of maps is of: with anything else it is stale.
#[derive(Clone, PartialEq)]
struct MapsOf {
    settings: SideSettings,
    light: Light,
    camera: Camera,
    scene: u64,
}

/// A side's maps: its layers side by side.
#[derive(Default)]
pub(crate) struct MapPicture {
    of: Option<MapsOf>,
    /// The processor draws it, which may take longer than a frame.
    job: Option<Beside<Option<(String, egui::ColorImage)>>>,
    shown: Option<egui::TextureHandle>,
    words: String,
}

/// Draws the window, and has its pictures made anew if they are stale and nothing moves.
pub(crate) fn show(app: &mut App, ui: &egui::Ui, rests: bool) {
    let mut is_open = app.settings.shows_maps;
    egui::Window::new("Maps")
        .open(&mut is_open)
        .default_pos([340.0, 60.0])
        .show(ui.ctx(), |ui| {
            for (i, name) in SIDES.iter().enumerate() {
                if rests && let Err(error) = update(app, ui.ctx(), i) {
                    app.message = Some(format!("{error:#}"));
                }
                let picture = &app.maps[i];
                ui.label(format!("{name}: {}", picture.words));
                if let Some(texture) = &picture.shown {
                    ui.image(egui::load::SizedTexture::from_handle(texture));
                }
            }
        });
    app.settings.shows_maps = is_open;
}

fn update(app: &mut App, ctx: &egui::Context, side: usize) -> Result<()> {
    let Some((camera, light)) = app.looked_at() else {
        app.maps[side] = MapPicture::default();
        return Ok(());
    };
    let of = MapsOf {
        settings: app.settings.sides[side].clone(),
        light,
        camera,
        scene: app.stage.geometry.fingerprint(),
    };
    let picture = &mut app.maps[side];
    if picture.of.as_ref() != Some(&of) {
        let casters = app.renderer.sides[side].set.casters_box();
        let geometry = app.stage.geometry.clone();
        picture.of = Some(of.clone());
        let wake = ctx.clone();
        picture.job = Some(Beside::start(
            move || drawn(&of, &geometry, casters),
            move || wake.request_repaint(),
        ));
        picture.words = "is being drawn".to_owned();
        picture.shown = None;
    }
    let Some(drawn) = picture.job.as_mut().and_then(Beside::take) else {
        return Ok(());
    };
    picture.job = None;
    picture.words = "no map".to_owned();
    if let Some((words, image)) = drawn? {
        let label = format!("maps {side}");
        picture.shown = Some(ctx.load_texture(label, image, egui::TextureOptions::LINEAR));
        picture.words = words;
    }
    Ok(())
}

/// Returns a few words and a picture of the first image that a technique draws; none if it draws none.
fn drawn(
    of: &MapsOf,
    geometry: &Geometry,
    casters: Aabb,
) -> Result<Option<(String, egui::ColorImage)>> {
    // Nothing is looked up: the maps are all that is wanted.
    let nothing = Receivers::empty(of.camera.size);
    let view = planned_view(&of.camera, &of.light, geometry, casters);
    let technique = of.settings.technique(&of.light);
    let mut recipe = technique.recipe(&view)?;
    recipe.keep_images = true;
    let shadows = Cpu::new().render(&view.with_receivers(&nothing), &recipe)?;
    let Some(image) = shadows.images.first() else {
        return Ok(None);
    };
    let desc = image.desc;
    let channels = desc.format.channels();
    let step = desc.size.max_element().div_ceil(SHOWN_SIDE).max(1);
    let shown = UVec2::new(desc.size.x.div_ceil(step), desc.size.y.div_ceil(step));
    let all = image.texels.iter().step_by(channels).copied();
    let is_drawn = |depth: &f32| *depth < 1.0;
    let [nearest, farthest] =
        [f32::min, f32::max].map(|pick| all.clone().filter(is_drawn).reduce(pick).unwrap_or(0.0));
    let mut pixels = Vec::new();
    for y in 0..shown.y {
        for layer in 0..desc.layers {
            for x in 0..shown.x {
                let texel = (layer * desc.size.y + y * step) * desc.size.x + x * step;
                let depth = image.texels[texel as usize * channels];
                pixels.push(color(depth, nearest, farthest));
            }
        }
    }
    let size = [(shown.x * desc.layers) as usize, shown.y as usize];
    let words = format!(
        "{} x {} texels, {} layers; light is near, dark is far, blue is nothing",
        desc.size.x, desc.size.y, desc.layers
    );
    Ok(Some((words, egui::ColorImage::new(size, pixels))))
}

fn color(depth: f32, nearest: f32, farthest: f32) -> egui::Color32 {
    if depth >= 1.0 {
        return egui::Color32::from_rgb(30, 40, 80);
    }
    let share = (depth - nearest) / (farthest - nearest).max(1e-12);
    egui::Color32::from_gray((235.0 - 200.0 * share.clamp(0.0, 1.0)) as u8)
}
