//! Renders the scene with light sets, like any program: one set for each of the two techniques.

mod buffers;
mod coarse;
mod convex;
pub(crate) mod mask;
mod materials;
mod overlay;
mod pass_clock;
mod pipelines;
pub(crate) mod present;
mod readback;
mod seen;
mod side;

use crate::{settings::Settings, stage::ViewerScene};
use anyhow::Result;
use buffers::SceneBuffers;
use mask::{PendingMask, ReceiverTextures};
use overlay::Overlay;
use pass_clock::PassClock;
use pipelines::{COLOR, COLOR_AS_READ, DEPTH, Layouts};
use seen::SeenPart;
use side::{Side, clip_from_world};
use std::time::Duration;
use umbrage::{Camera, Receivers, glam::UVec2, gpu::LightId};

/// The linear background colour.
const BACKGROUND: wgpu::Color = wgpu::Color {
    r: 0.42,
    g: 0.52,
    b: 0.66,
    a: 1.0,
};

/// Input of a frame.
pub(crate) struct FrameSettings<'a> {
    pub camera: &'a Camera,
    pub stage: &'a ViewerScene,
    pub settings: &'a Settings,
    /// `true` if something moves. At rest, a hidden side is prepared, too, since its mask may be
    /// requested, and maps of unknown time are redrawn once.
    pub is_moving: bool,
    /// `true` if details smaller than a pixel may be culled.
    pub is_coarse: bool,
}

impl FrameSettings<'_> {
    /// Returns the sides that the frame prepares.
    fn sides(&self) -> &'static [usize] {
        match (self.settings.split, self.settings.shown_side) {
            (None, 0) if self.is_moving => &[0],
            (None, _) if self.is_moving => &[1],
            _ => &[0, 1],
        }
    }

    /// Returns the columns of each visible side in the image.
    fn parts(&self) -> Vec<(usize, std::ops::Range<u32>)> {
        let width = self.camera.size.x;
        let mut parts = match self.settings.split {
            None => vec![(self.settings.shown_side.min(1), 0..width)],
            Some(divider) => {
                let column = (divider.clamp(0.0, 1.0) * width as f32).round() as u32;
                vec![(0, 0..column), (1, column..width)]
            }
        };
        parts.retain(|(_, part)| !part.is_empty());
        parts
    }
}

/// Renderer of a scene.
pub(crate) struct Renderer {
    device: wgpu::Device,
    queue: wgpu::Queue,
    layouts: Layouts,
    scene: SceneBuffers,
    pub sides: [Side; 2],
    overlays: [Overlay; 2],
    overlay_pipeline: wgpu::RenderPipeline,
    /// Clock of the passes. `None` if the device has no timestamps.
    pub clock: Option<PassClock>,
    targets: Option<Targets>,
}

/// Render targets of the image's size.
struct Targets {
    size: UVec2,
    color: wgpu::TextureView,
    as_read: wgpu::TextureView,
    depth: wgpu::TextureView,
}

impl Renderer {
    /// Uploads a scene.
    ///
    /// # Errors
    /// Returns an error if the device has no capacity for it.
    pub(crate) fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        stage: &ViewerScene,
        settings: &Settings,
    ) -> Result<Self> {
        let layouts = Layouts::new(device);
        let scene = SceneBuffers::new(device, queue, &layouts, stage)?;
        let [left, right] = &settings.sides;
        let sides = [
            Side::new(device, queue, &layouts, &scene, left)?,
            Side::new(device, queue, &layouts, &scene, right)?,
        ];
        Ok(Self {
            overlay_pipeline: pipelines::overlay(device, &layouts),
            clock: PassClock::new(device, queue),
            device: device.clone(),
            queue: queue.clone(),
            layouts,
            scene,
            sides,
            overlays: [Overlay::new(device), Overlay::new(device)],
            targets: None,
        })
    }

    /// Draws a frame and submits it. Returns the image, which stays the same until the size
    /// changes.
    ///
    /// # Errors
    /// Returns an error if a set refuses its input.
    pub(crate) fn frame(&mut self, frame: &FrameSettings<'_>) -> Result<&wgpu::TextureView> {
        let size = frame.camera.size;
        if self.targets.as_ref().is_none_or(|t| t.size != size) {
            self.targets = Some(Targets::new(&self.device, size));
        }
        let mut encoder = self
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        for &i in frame.sides() {
            let is_changed = self.sides[i].apply(frame.settings, i)?;
            if let Some(clock) = self.clock.as_mut().filter(|_| is_changed) {
                clock.forget_drawn(i);
            }
        }
        let moving = frame.is_moving.then_some(size);
        let is_timed = self.clock.as_mut().is_some_and(|clock| clock.begin(moving));
        // Take the clock out while the frame is recorded, since both it and the sides change.
        let mut clock = self.clock.take();
        let recorded = self.record(&mut encoder, frame, clock.as_mut().filter(|_| is_timed));
        self.clock = clock;
        recorded?;
        self.queue.submit([encoder.finish()]);
        if let Some(clock) = self.clock.as_mut().filter(|_| is_timed) {
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
        for &i in frame.sides() {
            let side = &mut self.sides[i];
            let is_unknown = clock
                .as_deref()
                .is_some_and(|clock| clock.drawn_ms[i].is_none());
            let casters = side.set.casters_box();
            let draws_all = !frame.is_moving && is_unknown;
            if draws_all && !casters.is_empty() {
                // Draw all maps in one timed frame. The frame after a change is mostly untimed,
                // because timestamps of another are pending.
                side.set.touch(&casters)?;
            }
            side.prepare(&self.device, &self.queue, &self.layouts, &self.scene, frame)?;
            match &mut clock {
                Some(clock) => {
                    let mut passes = Vec::new();
                    let stamps = clock.for_set();
                    side.set
                        .encode_timed(encoder, |_, _, _| (), &stamps, &mut passes)?;
                    clock.note(i, draws_all, &passes);
                }
                None => side.set.encode(encoder)?,
            }
        }
        let stamps = clock.as_mut().map(|clock| clock.for_picture());
        self.encode_picture(encoder, frame, stamps)?;
        if let Some(clock) = clock {
            clock.resolve(&self.device, encoder);
        }
        Ok(())
    }

    /// Reports whether the time of a side's maps and lists is unknown and can be measured.
    pub(crate) fn awaits_times(&self) -> bool {
        let clock = self.clock.as_ref();
        clock.is_some_and(|clock| clock.drawn_ms.contains(&None))
    }

    /// Removes and returns the last timed frame in motion: its size, pixels, and its device time.
    pub(crate) fn take_moving_frame(&mut self) -> Option<(UVec2, Duration)> {
        self.clock.as_mut()?.moving_frame.take()
    }

    /// Sets the overlay of a side: an image of this size, rows from the top, sRGB and opacity, a
    /// byte each. `None` removes it.
    pub(crate) fn show_overlay(&mut self, side: usize, picture: Option<(UVec2, Vec<u8>)>) {
        self.overlays[side].show(&self.device, &self.queue, &self.layouts, picture);
    }

    pub(crate) fn upload_receivers(&self, receivers: &Receivers) -> ReceiverTextures {
        ReceiverTextures::new(&self.device, &self.queue, receivers)
    }

    /// Requests a light's mask from a prepared side.
    ///
    /// # Errors
    /// Returns an error if the side's set does.
    pub(crate) fn request_mask(
        &mut self,
        side: usize,
        light: LightId,
        receivers: &ReceiverTextures,
    ) -> Result<PendingMask> {
        let set = &mut self.sides[side].set;
        PendingMask::request(&self.device, &self.queue, set, light, receivers)
    }

    /// Polls the device for finished work.
    ///
    /// # Errors
    /// Returns an error if the device does.
    pub(crate) fn poll(&self) -> Result<()> {
        self.device.poll(wgpu::PollType::Poll)?;
        Ok(())
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
        let parts = frame.parts();
        let share = |column: u32| column as f32 / size.x as f32;
        let has_perspective = frame.camera.clip_from_view.w_axis.w == 0.0;
        for (i, part) in &parts {
            pass.set_scissor_rect(part.start, 0, part.end - part.start, size.y);
            let seen = SeenPart {
                clip_from_world: clip_from_world(frame.camera),
                part: [part.start, part.end].map(share),
                eye: has_perspective.then(|| frame.camera.eye()),
                // Double it, since corners are farther away than the centre: this suffices for
                // views of 120 degrees.
                near: 2.0 * near_distance(frame.camera),
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
            let opacity = frame.settings.opacity();
            self.overlays[*i].draw(&self.queue, &mut pass, part, opacity);
        }
        Ok(())
    }
}

/// Returns the distance of the near plane, metres. Depth is reversed and infinite:
/// `near / distance`.
fn near_distance(camera: &Camera) -> f32 {
    camera.clip_from_view.w_axis.z
}

/// Returns the width of a pixel, metres. In perspective, at a distance of one metre.
fn pixel(camera: &Camera) -> f32 {
    2.0 / (camera.clip_from_view.y_axis.y.abs() * camera.size.y as f32)
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
