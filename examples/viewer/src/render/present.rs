//! Presentation of the image in the window.
//!
//! The panel's own shader would work, but for each pixel it also filters, dithers and blends. On
//! software drivers, which execute all branches of a shader, that took longer than most frames of
//! the scene.

use super::pipelines;
use egui_wgpu::CallbackTrait;
use umbrage::glam::UVec2;

/// Draws images into the window.
pub(crate) struct Presenter {
    device: wgpu::Device,
    layout: wgpu::BindGroupLayout,
    pipeline: wgpu::RenderPipeline,
    /// Samplers for images with the pixels of the window, and for all others.
    samplers: [wgpu::Sampler; 2],
}

/// An image that the panel's painter draws into the window.
struct Presented {
    pipeline: wgpu::RenderPipeline,
    group: wgpu::BindGroup,
}

impl Presenter {
    pub(crate) fn new(device: &wgpu::Device, window: wgpu::TextureFormat) -> Self {
        let layout = pipelines::layout(device, &[pipelines::IMAGE, pipelines::SAMPLER]);
        let samplers = [wgpu::FilterMode::Nearest, wgpu::FilterMode::Linear].map(|filter| {
            device.create_sampler(&wgpu::SamplerDescriptor {
                mag_filter: filter,
                min_filter: filter,
                ..wgpu::SamplerDescriptor::default()
            })
        });
        Self {
            pipeline: pipelines::present(device, &layout, window),
            device: device.clone(),
            layout,
            samplers,
        }
    }

    /// Returns a shape that shows an image in a part of the window with a different number of
    /// pixels.
    pub(crate) fn shape(
        &self,
        rect: egui::Rect,
        view: &wgpu::TextureView,
        size: UVec2,
        pixels: UVec2,
    ) -> egui::Shape {
        let sampler = &self.samplers[usize::from(size != pixels)];
        let resources = [
            wgpu::BindingResource::TextureView(view),
            wgpu::BindingResource::Sampler(sampler),
        ];
        let presented = Presented {
            pipeline: self.pipeline.clone(),
            group: pipelines::group(&self.device, &self.layout, resources),
        };
        egui_wgpu::Callback::new_paint_callback(rect, presented).into()
    }
}

impl CallbackTrait for Presented {
    fn paint(
        &self,
        _: egui::PaintCallbackInfo,
        pass: &mut wgpu::RenderPass<'static>,
        _: &egui_wgpu::CallbackResources,
    ) {
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.group, &[]);
        pass.draw(0..4, 0..1);
    }
}
