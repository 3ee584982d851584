//! A picture of figures that is laid over a side: errors, texels, cascades.

use super::pipelines::{self, Layouts, group};
use umbrage::glam::UVec2;

/// A picture, maybe none, and how it is bound.
pub(crate) struct Overlay {
    uniforms: wgpu::Buffer,
    layout: wgpu::BindGroupLayout,
    shown: Option<wgpu::BindGroup>,
    pub opacity: f32,
}

impl Overlay {
    pub(crate) fn new(device: &wgpu::Device, layouts: &Layouts) -> Self {
        let uniforms = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("overlay"),
            size: 16,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Self {
            uniforms,
            layout: layouts.overlay.clone(),
            shown: None,
            opacity: 1.0,
        }
    }

    /// Shows a picture: rows from the top, sRGB and opacity, a byte each.
    pub(crate) fn show(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        size: UVec2,
        rgba: &[u8],
    ) {
        let format = wgpu::TextureFormat::Rgba8UnormSrgb;
        let usage = wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST;
        let texture = pipelines::texture(device, size, format, usage, &[]);
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(4 * size.x),
            rows_per_image: None,
        };
        queue.write_texture(texture.as_image_copy(), rgba, layout, texture.size());
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let resources = [
            self.uniforms.as_entire_binding(),
            wgpu::BindingResource::TextureView(&view),
        ];
        self.shown = Some(group(device, &self.layout, resources));
    }

    pub(crate) fn clear(&mut self) {
        self.shown = None;
    }

    /// Draws the picture over a part of the width, from one share of it to another.
    pub(crate) fn draw(
        &self,
        queue: &wgpu::Queue,
        pass: &mut wgpu::RenderPass<'_>,
        part: [f32; 2],
    ) {
        let Some(group) = &self.shown else {
            return;
        };
        let cover = [part[0], part[1], self.opacity, 0.0];
        queue.write_buffer(&self.uniforms, 0, bytemuck::cast_slice(&cover));
        pass.set_bind_group(0, group, &[]);
        pass.draw(0..4, 0..1);
    }
}
