//! A picture without a window.

use crate::{
    Options, fly_camera::FlyCamera, gpu, pipelines::texture, renderer::Renderer, settings::Settings,
};
use anyhow::{Context as _, Result};
use std::path::Path;
use umbrage::glam::UVec2;

const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

/// Draws a picture and writes it to a file.
pub fn write(options: &Options, settings: &Settings, file: &Path) -> Result<()> {
    let size = options.size;
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let gpu = gpu::open(&instance, None)?;
    gpu.check_size(size)?;
    let errors = gpu.errors.clone();
    let mut renderer = Renderer::new(gpu.device, gpu.queue, FORMAT, settings)?;
    let usage = wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC;
    let target = texture(&renderer.device, size, FORMAT, usage);
    let view = target.create_view(&wgpu::TextureViewDescriptor::default());
    let camera = FlyCamera::default().camera(size);
    let mut encoder = renderer
        .device
        .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    let seconds = options.time.unwrap_or(0.0);
    renderer.frame(&mut encoder, &view, &camera, settings, seconds)?;
    let pixels = read(&renderer, encoder, &target)?;
    errors.check()?;
    for (reason, lights) in renderer.shadows.unserved() {
        eprintln!("{lights} lights have no shadows: {reason}");
    }
    image::save_buffer(file, &pixels, size.x, size.y, image::ColorType::Rgba8)
        .with_context(|| format!("can't write `{}`", file.display()))?;
    println!(
        "{}: {} x {} pixels, {}",
        file.display(),
        size.x,
        size.y,
        gpu.name
    );
    Ok(())
}

/// Submits the encoder and returns the target's pixels, row by row.
fn read(
    renderer: &Renderer,
    mut encoder: wgpu::CommandEncoder,
    target: &wgpu::Texture,
) -> Result<Vec<u8>> {
    let size = UVec2::new(target.width(), target.height());
    // Copied rows begin at multiples of this many bytes.
    let stride = (4 * size.x).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = renderer.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("picture"),
        size: u64::from(stride) * u64::from(size.y),
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let destination = wgpu::TexelCopyBufferInfo {
        buffer: &buffer,
        layout: wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(stride),
            rows_per_image: None,
        },
    };
    encoder.copy_texture_to_buffer(target.as_image_copy(), destination, target.size());
    renderer.queue.submit([encoder.finish()]);
    buffer.map_async(wgpu::MapMode::Read, .., |_| {});
    renderer.device.poll(wgpu::PollType::wait_indefinitely())?;
    let copied = buffer.get_mapped_range(..)?;
    let row = |copied: &[u8]| copied[..4 * size.x as usize].to_vec();
    Ok(copied.chunks(stride as usize).flat_map(row).collect())
}
