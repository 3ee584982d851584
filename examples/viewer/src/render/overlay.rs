//! Overlay of a side: errors, texels, cascades.

use super::pipelines::{self, Layouts, group};
use umbrage::glam::UVec2;

/// The overlay of a side, if there is one, and its bind group.
pub(crate) struct Overlay {
    uniforms: wgpu::Buffer,
    shown: Option<wgpu::BindGroup>,
}

impl Overlay {
    pub(super) fn new(device: &wgpu::Device) -> Self {
        let uniforms = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("overlay"),
            size: 16,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Self {
            uniforms,
            shown: None,
        }
    }

    /// Sets the image of the overlay, if there is one: rows from the top, sRGB and opacity, a byte
    /// each.
    pub(super) fn show(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        layouts: &Layouts,
        picture: Option<(UVec2, Vec<u8>)>,
    ) {
        self.shown = picture.map(|(size, rgba)| {
            let format = wgpu::TextureFormat::Rgba8UnormSrgb;
            let view = pipelines::upload(device, queue, size, format, &rgba);
            let resources = [
                self.uniforms.as_entire_binding(),
                wgpu::BindingResource::TextureView(&view),
            ];
            group(device, &layouts.overlay, resources)
        });
    }

    /// Draws the overlay over a part of the width, from one fraction of it to another.
    pub(super) fn draw(
        &self,
        queue: &wgpu::Queue,
        pass: &mut wgpu::RenderPass<'_>,
        part: [f32; 2],
        opacity: f32,
    ) {
        let Some(group) = &self.shown else {
            return;
        };
        let cover = [part[0], part[1], opacity, 0.0];
        queue.write_buffer(&self.uniforms, 0, bytemuck::cast_slice(&cover));
        pass.set_bind_group(0, group, &[]);
        pass.draw(0..4, 0..1);
    }
}
