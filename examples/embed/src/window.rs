//! The window: input, surface and panel.

use crate::{
    Options,
    fly_camera::FlyCamera,
    gpu::{self, DeviceErrors},
    panel::{self, Figures},
    renderer::Renderer,
    settings::Settings,
};
use anyhow::{Context as _, Result, bail};
use std::{
    collections::HashSet,
    sync::Arc,
    time::{Duration, Instant},
};
use umbrage::glam::{UVec2, Vec2, Vec3};
use winit::{
    application::ApplicationHandler,
    dpi::{PhysicalPosition, PhysicalSize},
    event::{DeviceEvent, DeviceId, ElementState, MouseButton, MouseScrollDelta, WindowEvent},
    event_loop::{ActiveEventLoop, ControlFlow, EventLoop},
    keyboard::{KeyCode, PhysicalKey},
    window::{CursorGrabMode, Window, WindowId},
};

/// How long to wait before trying again to draw into a window that shows nothing.
const PAUSE: Duration = Duration::from_millis(50);

/// Opens the window and runs until it is closed.
pub fn run(options: &Options, settings: Settings) -> Result<()> {
    let event_loop = EventLoop::new()
        .context("no window can be opened; `--png FILE` writes a picture without a display")?;
    event_loop.set_control_flow(ControlFlow::Wait);
    let mut app = App {
        size: options.size,
        seconds: options.time.unwrap_or(0.0),
        settings,
        program: None,
        error: None,
    };
    event_loop.run_app(&mut app)?;
    app.error.map_or(Ok(()), Err)
}

struct App {
    size: UVec2,
    seconds: f32,
    settings: Settings,
    program: Option<Program>,
    error: Option<anyhow::Error>,
}

/// All that there is while the window is open.
struct Program {
    window: Arc<Window>,
    instance: wgpu::Instance,
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    errors: DeviceErrors,
    renderer: Renderer,
    panel_input: egui_winit::State,
    panel_renderer: egui_wgpu::Renderer,
    view: FlyCamera,
    /// Keys that are down.
    keys: HashSet<KeyCode>,
    /// Keys that were pressed since the last frame, even if they are up again.
    tapped: HashSet<KeyCode>,
    /// Where the cursor was as it was hidden to look around.
    looks_from: Option<PhysicalPosition<f64>>,
    cursor: PhysicalPosition<f64>,
    last_frame: Instant,
    figures: Figures,
    settings: Settings,
    title: String,
    /// Of the scene.
    seconds: f32,
}

impl App {
    fn stop_on_error(&mut self, event_loop: &ActiveEventLoop, result: Result<()>) {
        if let Err(error) = result {
            self.error.get_or_insert(error);
            event_loop.exit();
        }
    }
}

impl ApplicationHandler for App {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.program.is_some() {
            return;
        }
        let opened = Program::open(event_loop, self).map(|program| {
            program.window.request_redraw();
            self.program = Some(program);
        });
        self.stop_on_error(event_loop, opened);
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(program) = &mut self.program else {
            return;
        };
        let result = match event {
            WindowEvent::CloseRequested | WindowEvent::Destroyed => {
                event_loop.exit();
                Ok(())
            }
            WindowEvent::RedrawRequested => program.redraw(),
            other => {
                program.input(&other);
                Ok(())
            }
        };
        self.stop_on_error(event_loop, result);
    }

    fn device_event(&mut self, _: &ActiveEventLoop, _: DeviceId, event: DeviceEvent) {
        if let (Some(program), DeviceEvent::MouseMotion { delta }) = (&mut self.program, event)
            && program.looks_from.is_some()
        {
            program.view.turn(Vec2::new(delta.0 as f32, delta.1 as f32));
        }
    }
}

impl Program {
    fn open(event_loop: &ActiveEventLoop, app: &App) -> Result<Self> {
        let size = PhysicalSize::new(app.size.x, app.size.y);
        let attributes = Window::default_attributes()
            .with_title("embed")
            .with_inner_size(size);
        let window = Arc::new(event_loop.create_window(attributes)?);
        let display = Box::new(event_loop.owned_display_handle());
        let instance =
            wgpu::Instance::new(wgpu::InstanceDescriptor::new_with_display_handle(display));
        let surface = instance.create_surface(window.clone())?;
        let gpu = gpu::open(&instance, Some(&surface))?;
        let size = window.inner_size();
        let mut config = surface
            .get_default_config(&gpu.adapter, size.width.max(1), size.height.max(1))
            .with_context(|| format!("{} can't draw into this window", gpu.name))?;
        // A format that encodes sRGB, where there is one; else the program's shaders encode.
        let formats = surface.get_capabilities(&gpu.adapter).formats;
        let srgb = formats.iter().find(|format| format.is_srgb());
        config.format = srgb.copied().unwrap_or(config.format);
        config.present_mode = wgpu::PresentMode::AutoVsync;
        surface.configure(&gpu.device, &config);
        let panel_renderer = egui_wgpu::Renderer::new(
            &gpu.device,
            config.format,
            egui_wgpu::RendererOptions::default(),
        );
        let most = gpu.device.limits().max_texture_dimension_2d as usize;
        let panel_input = egui_winit::State::new(
            egui::Context::default(),
            egui::ViewportId::ROOT,
            &window,
            Some(window.scale_factor() as f32),
            window.theme(),
            Some(most),
        );
        let renderer = Renderer::new(gpu.device, gpu.queue, config.format, &app.settings)?;
        Ok(Self {
            window,
            instance,
            surface,
            config,
            errors: gpu.errors,
            renderer,
            panel_input,
            panel_renderer,
            view: FlyCamera::default(),
            keys: HashSet::new(),
            tapped: HashSet::new(),
            looks_from: None,
            cursor: PhysicalPosition::default(),
            last_frame: Instant::now(),
            figures: Figures::default(),
            settings: app.settings.clone(),
            title: String::new(),
            seconds: app.seconds,
        })
    }

    fn input(&mut self, event: &WindowEvent) {
        // What the hidden cursor points at is nobody's business.
        let is_hidden = self.looks_from.is_some();
        let is_move = matches!(event, WindowEvent::CursorMoved { .. });
        let taken = !(is_hidden && is_move)
            && self
                .panel_input
                .on_window_event(&self.window, event)
                .consumed;
        match event {
            WindowEvent::Resized(_) => self.configure(),
            WindowEvent::Focused(false) => {
                self.keys.clear();
                self.look(false);
            }
            WindowEvent::CursorMoved { position, .. } if !is_hidden => self.cursor = *position,
            WindowEvent::MouseInput {
                state,
                button: MouseButton::Right,
                ..
            } => {
                let is_pressed = *state == ElementState::Pressed;
                self.look(is_pressed && !taken);
            }
            WindowEvent::MouseWheel { delta, .. } if !taken => {
                let lines = match delta {
                    MouseScrollDelta::LineDelta(_, lines) => *lines,
                    MouseScrollDelta::PixelDelta(pixels) => pixels.y as f32 / 40.0,
                };
                let speed = self.view.speed * 1.2_f32.powf(lines);
                self.view.speed = speed.clamp(0.2, 200.0);
            }
            WindowEvent::KeyboardInput { event, .. } => {
                let PhysicalKey::Code(key) = event.physical_key else {
                    return;
                };
                if event.state == ElementState::Released {
                    self.keys.remove(&key);
                } else if !taken {
                    self.keys.insert(key);
                    self.tapped.insert(key);
                }
            }
            _ => {}
        }
    }

    /// Begins or ends looking around: meanwhile the cursor is hidden and stays in the window, where the system can do that.
    fn look(&mut self, begins: bool) {
        if begins == self.looks_from.is_some() {
            return;
        }
        self.window.set_cursor_visible(!begins);
        if begins {
            self.looks_from = Some(self.cursor);
            // Without a grab the view turns until the cursor meets the edge of the screen: no reason to stop.
            let _ = self
                .window
                .set_cursor_grab(CursorGrabMode::Locked)
                .or_else(|_| self.window.set_cursor_grab(CursorGrabMode::Confined));
        } else {
            let _ = self.window.set_cursor_grab(CursorGrabMode::None);
            if let Some(position) = self.looks_from.take() {
                let _ = self.window.set_cursor_position(position);
            }
        }
    }

    fn fly(&mut self, passed: Duration) {
        let pressed: HashSet<KeyCode> = self.keys.union(&self.tapped).copied().collect();
        self.tapped.clear();
        let is_down = |key: KeyCode| f32::from(u8::from(pressed.contains(&key)));
        let along = |less: KeyCode, more: KeyCode| is_down(more) - is_down(less);
        let up = along(KeyCode::KeyQ, KeyCode::KeyE) + along(KeyCode::ShiftLeft, KeyCode::Space);
        let way = Vec3::new(
            along(KeyCode::KeyA, KeyCode::KeyD),
            up.clamp(-1.0, 1.0),
            along(KeyCode::KeyS, KeyCode::KeyW),
        );
        // A long frame is no long flight.
        let seconds = passed.as_secs_f32().min(0.25);
        self.view.fly(way, seconds);
        if self.settings.moving {
            self.seconds += passed.as_secs_f32();
        }
    }

    /// Makes the surface as large as the window; nothing can be as small as a window without pixels.
    fn configure(&mut self) {
        let size = self.window.inner_size();
        if size.width == 0 || size.height == 0 {
            return;
        }
        self.config.width = size.width;
        self.config.height = size.height;
        self.surface.configure(&self.renderer.device, &self.config);
    }

    /// Draws a frame, and asks for the next one.
    fn redraw(&mut self) -> Result<()> {
        self.errors.check()?;
        let size = self.window.inner_size();
        let has_pixels = size.width > 0 && size.height > 0;
        let texture = if has_pixels {
            self.next_texture()?
        } else {
            None
        };
        match texture {
            Some(texture) => self.draw(texture)?,
            None => std::thread::sleep(PAUSE),
        }
        self.window.request_redraw();
        Ok(())
    }

    /// Returns what to draw into; none if there is nothing just now.
    fn next_texture(&mut self) -> Result<Option<wgpu::SurfaceTexture>> {
        match self.surface.get_current_texture() {
            wgpu::CurrentSurfaceTexture::Success(texture)
            | wgpu::CurrentSurfaceTexture::Suboptimal(texture) => Ok(Some(texture)),
            wgpu::CurrentSurfaceTexture::Timeout | wgpu::CurrentSurfaceTexture::Occluded => {
                Ok(None)
            }
            wgpu::CurrentSurfaceTexture::Outdated => {
                self.configure();
                Ok(None)
            }
            wgpu::CurrentSurfaceTexture::Lost => {
                self.surface = self.instance.create_surface(self.window.clone())?;
                self.configure();
                Ok(None)
            }
            wgpu::CurrentSurfaceTexture::Validation => {
                self.errors.check()?;
                bail!("the window gives nothing to draw into")
            }
        }
    }

    fn draw(&mut self, texture: wgpu::SurfaceTexture) -> Result<()> {
        let now = Instant::now();
        let passed = now - self.last_frame;
        self.last_frame = now;
        self.fly(passed);
        let size = UVec2::new(texture.texture.width(), texture.texture.height());
        let camera = self.view.camera(size);
        let target = texture
            .texture
            .create_view(&wgpu::TextureViewDescriptor::default());
        let mut encoder = self
            .renderer
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let times =
            self.renderer
                .frame(&mut encoder, &target, &camera, &self.settings, self.seconds)?;
        self.figures.add(Figures {
            times,
            frame: passed,
        });
        let mut settings = self.settings.clone();
        let input = self.panel_input.take_egui_input(&self.window);
        let context = self.panel_input.egui_ctx().clone();
        let output = context.run_ui(input, |ui| {
            panel::show(
                ui,
                &mut settings,
                &self.renderer,
                &camera,
                self.view.speed,
                &self.figures,
            );
        });
        self.panel_input
            .handle_platform_output(&self.window, output.platform_output);
        let jobs = context.tessellate(output.shapes, output.pixels_per_point);
        self.draw_panel(
            encoder,
            &target,
            size,
            output.pixels_per_point,
            output.textures_delta,
            &jobs,
        );
        self.renderer.queue.present(texture);
        self.take(settings);
        Ok(())
    }

    /// Records the panel behind the picture, and submits both.
    fn draw_panel(
        &mut self,
        mut encoder: wgpu::CommandEncoder,
        target: &wgpu::TextureView,
        size: UVec2,
        pixels_per_point: f32,
        mut textures: egui::TexturesDelta,
        jobs: &[egui::ClippedPrimitive],
    ) {
        let screen = egui_wgpu::ScreenDescriptor {
            size_in_pixels: size.to_array(),
            pixels_per_point,
        };
        let (device, queue) = (&self.renderer.device, &self.renderer.queue);
        let panel = &mut self.panel_renderer;
        for (id, deltas) in textures.set.drain() {
            for delta in deltas {
                panel.update_texture(device, queue, id, &delta);
            }
        }
        let before = panel.update_buffers(device, queue, &mut encoder, jobs, &screen);
        let mut pass = encoder
            .begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("panel"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: target,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Load,
                        store: wgpu::StoreOp::Store,
                    },
                })],
                ..wgpu::RenderPassDescriptor::default()
            })
            .forget_lifetime();
        panel.render(&mut pass, jobs, &screen);
        drop(pass);
        queue.submit(before.into_iter().chain([encoder.finish()]));
        for id in textures.free.drain() {
            panel.free_texture(&id);
        }
    }

    /// Takes what the user changed in the panel, and says in the title what is shown.
    fn take(&mut self, settings: Settings) {
        self.settings = settings;
        let way = if self.settings.deferred {
            "deferred"
        } else {
            "forward"
        };
        let technique = self.settings.preset.technique();
        let title = format!("embed: {}, {way}", technique.name());
        if title != self.title {
            self.window.set_title(&title);
            self.title = title;
        }
    }
}
