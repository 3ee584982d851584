//! Draws the scene through light sets, as any program would: one set for each of the two techniques that are compared.

mod buffers;
mod coarse;
mod convex;
mod holes;
pub(crate) mod mask;
mod overlay;
mod pass_clock;
mod pipelines;
pub(crate) mod present;
mod side;

use crate::{lights::EditLight, settings::SideSettings, stage::Stage};
use anyhow::Result;
use buffers::{SceneBuffers, SeenPart};
use overlay::Overlay;
use pass_clock::{PassClock, TimedFrame};
use pipelines::{COLOR, COLOR_AS_READ, DEPTH, Layouts};
use side::{Side, clip_from_world};
use umbrage::{Camera, glam::UVec2};

/// What the two sides are called.
pub(crate) const SIDES: [&str; 2] = ["left", "right"];

/// The background, linear.
const BACKGROUND: wgpu::Color = wgpu::Color {
    r: 0.42,
    g: 0.52,
    b: 0.66,
    a: 1.0,
};

/// Which of the two sides are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Shown {
    /// One of them: 0 or 1.
    One(usize),
    /// The first left of this share of the width, the second right of it.
    Both(f32),
}

/// What a frame is drawn from.
pub(crate) struct FrameSettings<'a> {
    pub camera: &'a Camera,
    pub stage: &'a Stage,
    pub lights: &'a [EditLight],
    pub sides: [&'a SideSettings; 2],
    pub shown: Shown,
    /// Whether details smaller than a pixel may be left out.
    pub is_coarse: bool,
    /// Whether a side that is not shown is made ready, too: its mask may be asked for. Maps whose time isn't known are drawn once more.
    pub prepares_both: bool,
}

pub(crate) struct Renderer {
    device: wgpu::Device,
    queue: wgpu::Queue,
    layouts: Layouts,
    scene: SceneBuffers,
    pub sides: [Side; 2],
    pub overlays: [Overlay; 2],
    overlay_pipeline: wgpu::RenderPipeline,
    clock: Option<PassClock>,
    targets: Option<Targets>,
}

/// What is as large as the picture.
struct Targets {
    size: UVec2,
    color: wgpu::TextureView,
    as_read: wgpu::TextureView,
    depth: wgpu::TextureView,
}

/// Returns the sides that a frame draws, 0 or 1.
fn drawn_sides(frame: &FrameSettings<'_>) -> &'static [usize] {
    match frame.shown {
        _ if frame.prepares_both => &[0, 1],
        Shown::One(0) => &[0],
        Shown::One(_) => &[1],
        Shown::Both(_) => &[0, 1],
    }
}

impl Renderer {
    /// Uploads a scene.
    ///
    /// # Errors
    /// Errors if the device has no room for it.
    pub(crate) fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        stage: &Stage,
        sides: [&SideSettings; 2],
    ) -> Result<Self> {
        let layouts = Layouts::new(device);
        let scene = SceneBuffers::new(
            device,
            queue,
            &layouts,
            &stage.geometry,
            &stage.materials,
            &stage.textures,
        )?;
        let sides = [
            Side::new(device, &layouts, &scene, sides[0])?,
            Side::new(device, &layouts, &scene, sides[1])?,
        ];
        let overlays = [
            Overlay::new(device, &layouts),
            Overlay::new(device, &layouts),
        ];
        Ok(Self {
            overlay_pipeline: pipelines::overlay(device, &layouts),
            clock: PassClock::new(device, queue),
            device: device.clone(),
            queue: queue.clone(),
            layouts,
            scene,
            sides,
            overlays,
            targets: None,
        })
    }

    /// Draws a frame and submits it. Returns what it was drawn into, for the panel to show; it is the same until the size changes.
    ///
    /// # Errors
    /// Errors if a set refuses what it is given.
    pub(crate) fn frame(&mut self, frame: &FrameSettings<'_>) -> Result<&wgpu::TextureView> {
        let size = frame.camera.size;
        if self.targets.as_ref().is_none_or(|t| t.size != size) {
            self.targets = Some(Targets::new(&self.device, size));
        }
        let mut encoder = self
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        for &i in drawn_sides(frame) {
            if self.sides[i].apply(frame.lights, frame.sides[i])? {
                self.forget_drawn(i);
            }
        }
        // Taken out while the frame is recorded, since both it and the sides change.
        let mut clock = self.clock.take();
        let moving = (!frame.prepares_both).then_some(size);
        let is_timed = clock.as_mut().is_some_and(|clock| clock.begin(moving));
        let recorded = self.record(&mut encoder, frame, clock.as_mut().filter(|_| is_timed));
        self.clock = clock;
        recorded?;
        self.queue.submit([encoder.finish()]);
        if let Some(clock) = self.clock.as_ref().filter(|_| is_timed) {
            clock.fetch();
        }
        match &self.targets {
            Some(targets) => Ok(&targets.as_read),
            None => anyhow::bail!("the picture has no size"),
        }
    }

    fn record(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &FrameSettings<'_>,
        mut clock: Option<&mut PassClock>,
    ) -> Result<()> {
        for &i in drawn_sides(frame) {
            let side = &mut self.sides[i];
            let is_wanted = clock
                .as_deref()
                .is_some_and(|clock| clock.drawn_ms(i).is_none());
            let everything = side.set.casters_box();
            let draws_all = frame.prepares_both && is_wanted;
            if draws_all && !everything.is_empty() {
                // All maps are drawn in one frame that is timed. The frame after a change mostly isn't: stamps of another are on their way.
                side.set.touch(&everything)?;
            }
            side.prepare(&self.device, &self.queue, &self.layouts, &self.scene, frame)?;
            match &mut clock {
                Some(clock) => side.encode_timed(encoder, clock, i, draws_all)?,
                None => side.set.encode(encoder)?,
            }
        }
        let stamps = clock.as_mut().map(|clock| clock.of_picture());
        self.encode_picture(encoder, frame, stamps)?;
        if let Some(clock) = clock {
            clock.resolve(encoder);
        }
        Ok(())
    }

    /// Returns what the passes of a frame took on the device, milliseconds; of one of the last frames.
    pub(crate) fn pass_times(&self) -> &[(String, f64)] {
        self.clock.as_ref().map_or(&[], |clock| &clock.times)
    }

    /// Whether the device tells what passes take.
    pub(crate) fn has_clock(&self) -> bool {
        self.clock.is_some()
    }

    /// Returns the last frame that was timed while something moved, once.
    pub(crate) fn take_moving_frame(&mut self) -> Option<TimedFrame> {
        self.clock.as_mut()?.take_moving_frame()
    }

    /// Returns what a side's maps and lists, of all lights, took on the device when all of them were drawn, milliseconds; none before that is
    /// known.
    pub(crate) fn drawn_ms(&self, side: usize) -> Option<f64> {
        self.clock.as_ref()?.drawn_ms(side)
    }

    /// Forgets what a side's maps and lists took, since they are others now.
    fn forget_drawn(&mut self, side: usize) {
        if let Some(clock) = &mut self.clock {
            clock.forget_drawn(side);
        }
    }

    /// Whether what a side's maps and lists take isn't known yet, and can be.
    pub(crate) fn awaits_times(&self) -> bool {
        let is_unknown = |clock: &PassClock| (0..2).any(|side| clock.drawn_ms(side).is_none());
        self.clock.as_ref().is_some_and(is_unknown)
    }

    fn encode_picture(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        frame: &FrameSettings<'_>,
        stamps: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) -> Result<()> {
        let Some(targets) = &self.targets else {
            return Ok(());
        };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("picture"),
            color_attachments: &[color_attachment(
                &targets.color,
                wgpu::LoadOp::Clear(BACKGROUND),
            )],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &targets.depth,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            timestamp_writes: stamps,
            ..wgpu::RenderPassDescriptor::default()
        });
        let size = targets.size;
        let parts = parts(frame.shown, size.x);
        let share = |column: u32| column as f32 / size.x as f32;
        let has_perspective = frame.camera.clip_from_view.w_axis.w == 0.0;
        for (i, part) in &parts {
            pass.set_scissor_rect(part.start, 0, part.end - part.start, size.y);
            let seen = SeenPart {
                clip_from_world: clip_from_world(frame.camera),
                part: [part.start, part.end].map(share),
                eye: has_perspective.then(|| frame.camera.eye()),
                // Its corners are farther away than its middle: twice is enough for views of 120 degrees.
                near: 2.0 * near(frame.camera),
                coarse_pixel: frame.is_coarse.then(|| pixel(frame.camera)),
            };
            self.sides[*i].draw(&mut pass, &self.scene, &seen)?;
        }
        drop(pass);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("figures"),
            color_attachments: &[color_attachment(&targets.color, wgpu::LoadOp::Load)],
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_pipeline(&self.overlay_pipeline);
        for (i, part) in &parts {
            let part = [part.start, part.end].map(share);
            self.overlays[*i].draw(&self.queue, &mut pass, part);
        }
        Ok(())
    }
}

/// Returns how far the near plane is from the eye, metres: depth is reversed and endless, so that it is `near / distance`.
fn near(camera: &Camera) -> f32 {
    camera.clip_from_view.w_axis.z
}

/// Returns how many metres a pixel spans; in perspective, a metre away.
fn pixel(camera: &Camera) -> f32 {
    2.0 / (camera.clip_from_view.y_axis.y.abs() * camera.size.y as f32)
}

/// Returns which columns each side is drawn into; sides without any are left out.
fn parts(shown: Shown, width: u32) -> Vec<(usize, std::ops::Range<u32>)> {
    let mut parts = match shown {
        Shown::One(side) => vec![(side.min(1), 0..width)],
        Shown::Both(divider) => {
            let column = (divider.clamp(0.0, 1.0) * width as f32).round() as u32;
            vec![(0, 0..column), (1, column..width)]
        }
    };
    parts.retain(|(_, part)| !part.is_empty());
    parts
}

fn color_attachment(
    view: &wgpu::TextureView,
    load: wgpu::LoadOp<wgpu::Color>,
) -> Option<wgpu::RenderPassColorAttachment<'_>> {
    Some(wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations {
            load,
            store: wgpu::StoreOp::Store,
        },
    })
}

impl Targets {
    fn new(device: &wgpu::Device, size: UVec2) -> Self {
        let drawn = wgpu::TextureUsages::RENDER_ATTACHMENT;
        let read = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_SRC;
        let image = pipelines::texture(device, size, COLOR, drawn | read, &[COLOR_AS_READ]);
        let depth = pipelines::texture(device, size, DEPTH, drawn, &[]);
        let view_as = |format, usage| {
            image.create_view(&wgpu::TextureViewDescriptor {
                format: Some(format),
                usage: Some(usage),
                ..wgpu::TextureViewDescriptor::default()
            })
        };
        Self {
            size,
            color: view_as(COLOR, drawn),
            as_read: view_as(COLOR_AS_READ, wgpu::TextureUsages::TEXTURE_BINDING),
            depth: depth.create_view(&wgpu::TextureViewDescriptor::default()),
        }
    }
}
