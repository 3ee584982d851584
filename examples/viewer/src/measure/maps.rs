//! Images of maps, as the light draws them.

use super::subject::Subject;
use crate::{job::Job, side::SideSettings};
use anyhow::Result;
use egui::{Color32, ColorImage, TextureHandle};
use umbrage::{Backend as _, Receivers, cpu::Cpu, glam::UVec2};

/// Greatest side of a displayed layer, pixels.
const SHOWN_SIDE: u32 = 384;

/// The maps of a side: its layers next to each other.
#[derive(Default)]
pub(crate) struct MapPicture {
    /// Input of the image. With another input it is stale.
    of: Option<(Subject, SideSettings)>,
    /// Drawing on the CPU, which may take longer than a frame.
    job: Option<Job<Option<(String, ColorImage)>>>,
    pub shown: Option<TextureHandle>,
    pub label: String,
}

impl MapPicture {
    /// Starts to draw the maps if they are stale, and receives finished ones.
    ///
    /// # Errors
    /// Returns an error if the technique refuses the light.
    pub(crate) fn update(
        &mut self,
        ctx: &egui::Context,
        subject: Option<Subject>,
        settings: &SideSettings,
    ) -> Result<()> {
        let of = subject.map(|subject| (subject, settings.clone()));
        if self.of != of {
            *self = Self::default();
            self.of.clone_from(&of);
            if let Some((subject, settings)) = of {
                self.label = "drawing".to_owned();
                self.job = Some(Job::start(ctx, move |_| {
                    draw(&subject, &settings).map(Some)
                }));
            }
        }
        let Some(drawn) = self.job.as_mut().and_then(Job::take) else {
            return Ok(());
        };
        self.job = None;
        self.label = "no map".to_owned();
        if let Some((label, image)) = drawn? {
            let texture = ctx.load_texture("maps", image, egui::TextureOptions::LINEAR);
            self.shown = Some(texture);
            self.label = label;
        }
        Ok(())
    }
}

/// Returns a label and an image of the first map of a technique. `None` if it draws none.
fn draw(subject: &Subject, settings: &SideSettings) -> Result<Option<(String, ColorImage)>> {
    // Use no receivers: only the maps are needed.
    let nothing = Receivers::empty(subject.camera.size);
    let view = subject.view();
    let mut recipe = settings.technique(&subject.light).recipe(&view)?;
    recipe.keep_images = true;
    let shadows = Cpu::new().render(&view.with_receivers(&nothing), &recipe)?;
    let Some(image) = shadows.images.first() else {
        return Ok(None);
    };
    let desc = image.desc;
    let channels = desc.format.channels();
    let step = desc.size.max_element().div_ceil(SHOWN_SIDE).max(1);
    let shown = UVec2::new(desc.size.x.div_ceil(step), desc.size.y.div_ceil(step));
    let depths = image.texels.iter().step_by(channels).copied();
    let drawn = depths.filter(|depth| *depth < 1.0);
    let nearest = drawn.clone().reduce(f32::min).unwrap_or(0.0);
    let farthest = drawn.reduce(f32::max).unwrap_or(0.0);
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
    let label = format!(
        "{} x {} texels, {} layers; bright: near, dark: far, blue: empty",
        desc.size.x, desc.size.y, desc.layers
    );
    Ok(Some((label, ColorImage::new(size, pixels))))
}

fn color(depth: f32, nearest: f32, farthest: f32) -> Color32 {
    if depth >= 1.0 {
        return Color32::from_rgb(30, 40, 80);
    }
    let share = (depth - nearest) / (farthest - nearest).max(1e-12);
    Color32::from_gray((235.0 - 200.0 * share.clamp(0.0, 1.0)) as u8)
}
