//! The shade pass: colours for all that the camera sees.

use crate::{
    filter::color_attachment,
    frame::{FrameInputs, RendererOptions},
    receive::{gbuffer, groups},
    resources::{
        bindings::{Binding, Bound, Slot},
        counters::ResourceFactory,
        images::{GpuImage, fit_images},
        kernel_stage::{KernelStage, Sources},
        pipelines::Pipelines,
    },
    wgsl::{kernel::kernel_wgsl, stages::shade_shader},
};
use umbrage_core::{Format, ImageDesc, Shade};
use wgpu::{Color, CommandEncoder, RenderPassDescriptor, ShaderStages, TextureFormat};

/// Ready to be encoded; without a picture where the recipe doesn't shade.
#[derive(Debug, Default)]
pub(crate) struct ShadePass {
    kernel: KernelStage,
    gbuffer: Binding,
    picture: Vec<GpuImage>,
    background: Color,
}

impl ShadePass {
    pub(crate) fn prepare(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        sources: &mut Sources<'_>,
        options: RendererOptions,
        frame: &FrameInputs<'_>,
        mask: &GpuImage,
    ) {
        let Some(shade) = &sources.recipe.shade else {
            return *self = Self::default();
        };
        let picture = ImageDesc {
            label: "umbrage picture",
            size: frame.size,
            layers: 1,
            format: Format::Rgba32,
        };
        fit_images(factory, &mut self.picture, &[picture], &[]);
        self.background = background(shade);
        let shape = self.kernel.bind(
            factory,
            pipelines,
            sources,
            &*shade.kernel,
            &[],
            &shade.tables,
        );
        let (mut slots, mut bound) = gbuffer(&frame.receivers);
        slots.push(Slot::Floats { layered: false });
        bound.push(Bound::View(mask.whole.clone()));
        let layout = pipelines
            .layouts
            .get(factory, ShaderStages::FRAGMENT, &slots);
        self.gbuffer.set(factory, "umbrage seen", &layout, bound);
        let text = shade_shader(
            &kernel_wgsl(&*shade.kernel, &shape, options.kernel_group),
            options.gbuffer_group(),
        );
        let groups = groups(options, &self.kernel, &layout);
        self.kernel.pipeline = Some(pipelines.kernel(
            factory,
            "umbrage shade",
            text,
            "umbrage_shade",
            TextureFormat::Rgba32Float,
            &groups,
        ));
    }

    /// Records the pass, if the recipe shades.
    pub(crate) fn encode(&self, encoder: &mut CommandEncoder, options: RendererOptions) {
        let (Some(picture), Some(pipeline)) = (self.picture(), &self.kernel.pipeline) else {
            return;
        };
        let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
            label: Some("umbrage shade"),
            color_attachments: &[Some(color_attachment(&picture.whole, self.background))],
            ..RenderPassDescriptor::default()
        });
        pass.set_pipeline(pipeline);
        pass.set_bind_group(options.kernel_group, self.kernel.binding.group(), &[]);
        pass.set_bind_group(options.gbuffer_group(), self.gbuffer.group(), &[]);
        pass.draw(0..3, 0..1);
    }

    pub(crate) fn picture(&self) -> Option<&GpuImage> {
        self.picture.first()
    }
}

fn background(shade: &Shade) -> Color {
    let [r, g, b, a] = shade.background.map(f64::from);
    Color { r, g, b, a }
}
