//! The cast stage: triangles into every light space.

use crate::{
    filter::clear,
    frame::FrameInputs,
    resources::{
        bindings::{Binding, Bound, Slot},
        counters::ResourceFactory,
        draws::{Draw, DrawList, Vertex},
        faces::FaceBuffers,
        images::GpuImage,
        matrices::{Matrices, matrix_layout},
        pipelines::{CastKey, Peel, Pipelines},
        timestamps::{PassTimestamps, TimedStage, pass_stamps},
    },
    targets::CastTarget,
};
use umbrage_core::{Cast, CastMode, Format, Source};
use wgpu::{
    BindGroupLayout, CommandEncoder, RenderPass, RenderPassDescriptor, RenderPipeline,
    ShaderStages, TextureView,
};

/// Ready to be encoded.
#[derive(Debug, Default)]
pub(crate) struct CastStage {
    pub(crate) targets: Vec<CastTarget>,
    /// For each target, whether it draws what the technique made.
    faces: Vec<bool>,
    list: DrawList,
    /// For each target, and in it for each draw.
    pipelines: Vec<Vec<RenderPipeline>>,
    /// For each target, what it peels off.
    others: Vec<Binding>,
    /// Layers that casts read before any cast writes them.
    clears: Vec<(Format, TextureView)>,
    spaces: Matrices,
    places: Matrices,
}

impl CastStage {
    pub(crate) fn prepare(
        &mut self,
        maker: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        casts: &[Cast],
        images: &[GpuImage],
        faces: &mut FaceBuffers,
        frame: &FrameInputs<'_>,
    ) {
        self.targets = (0..casts.len())
            .map(|i| CastTarget::new(casts, i, images))
            .collect();
        self.faces = casts
            .iter()
            .map(|c| matches!(c.source, Source::Faces(_)))
            .collect();
        self.list = DrawList::new(maker, faces, casts, frame);
        self.clears = read_unwritten(casts, images);
        self.spaces.write(
            maker,
            pipelines,
            self.targets.iter().map(|t| t.clip_from_world),
        );
        self.places.write(maker, pipelines, self.list.places());
        let layouts = Layouts::new(maker, pipelines);
        self.bind_others(maker, &layouts);
        let mut pipeline = |target: &CastTarget, draw: &Draw| {
            let key = CastKey {
                depth: target.state(),
                layout: draw.layout,
                vertex: draw.vertex,
                peel: Peel::of(target),
            };
            pipelines.cast(maker, key, &layouts.of(&key))
        };
        let parts = self.targets.iter().zip(&self.list.casts);
        let draws = &self.list.draws;
        self.pipelines = parts
            .map(|(t, part)| draws[part.clone()].iter().map(|d| pipeline(t, d)).collect())
            .collect();
    }

    fn bind_others(&mut self, maker: &mut ResourceFactory<'_>, layouts: &Layouts) {
        self.others
            .resize_with(self.targets.len(), Binding::default);
        for (binding, target) in self.others.iter_mut().zip(&self.targets) {
            if let Some(other) = &target.behind {
                binding.set(
                    maker,
                    "umbrage peeled layer",
                    &layouts.other,
                    vec![Bound::View(other.clone())],
                );
            }
        }
    }

    /// Whether all that a caller needs to draw a cast is its target, one after the other.
    pub(crate) fn are_plain(&self) -> bool {
        let plain = |t: &CastTarget| t.behind.is_none() && t.format().is_depth();
        self.targets.iter().all(plain) && !self.faces.contains(&true)
    }

    /// Whether a cast draws what the technique made.
    pub(crate) fn draws_faces(&self, cast: usize) -> bool {
        self.faces[cast]
    }

    /// Gives layers that casts read, and that none wrote before, what the recipe promises.
    pub(crate) fn clear(&self, encoder: &mut CommandEncoder) {
        self.clears
            .iter()
            .for_each(|(format, view)| clear(encoder, *format, view));
    }

    pub(crate) fn encode(&self, encoder: &mut CommandEncoder, stamps: Option<&PassTimestamps<'_>>) {
        self.clear(encoder);
        (0..self.targets.len()).for_each(|i| self.encode_one(encoder, i, stamps));
    }

    /// One cast without the clearing of what it reads.
    pub(crate) fn encode_one(
        &self,
        encoder: &mut CommandEncoder,
        i: usize,
        stamps: Option<&PassTimestamps<'_>>,
    ) {
        let mut pass = encoder.begin_render_pass(&RenderPassDescriptor {
            label: Some("umbrage cast"),
            depth_stencil_attachment: Some(self.targets[i].attachment()),
            timestamp_writes: pass_stamps(stamps, TimedStage::Cast, i, self.targets.len()),
            ..RenderPassDescriptor::default()
        });
        self.spaces.bind(&mut pass, 0, i);
        if self.targets[i].behind.is_some() {
            pass.set_bind_group(2, self.others[i].group(), &[]);
        }
        self.draw(&mut pass, i);
    }

    fn draw(&self, pass: &mut RenderPass<'_>, cast: usize) {
        let pipelines = &self.pipelines[cast];
        for ((i, place), pipeline) in self.list.casts[cast].clone().enumerate().zip(pipelines) {
            let draw = &self.list.draws[place];
            if i == 0 || pipelines[i - 1] != *pipeline {
                pass.set_pipeline(pipeline);
            }
            if draw.vertex == Vertex::Local {
                self.places.bind(pass, 1, place);
            }
            draw.encode(pass);
        }
    }
}

/// The bind groups of casts: 0 the space, 1 the place, 2 what is peeled off.
struct Layouts {
    matrix: BindGroupLayout,
    other: BindGroupLayout,
}

impl Layouts {
    fn new(maker: &ResourceFactory<'_>, pipelines: &mut Pipelines) -> Self {
        let matrix = matrix_layout(maker, pipelines);
        let other = pipelines.layouts.get(
            maker,
            ShaderStages::FRAGMENT,
            &[Slot::Floats { layered: false }],
        );
        Self { matrix, other }
    }

    fn of(&self, key: &CastKey) -> [Option<&BindGroupLayout>; 3] {
        let place = (key.vertex == Vertex::Local).then_some(&self.matrix);
        [
            Some(&self.matrix),
            place,
            (key.peel != Peel::Nothing).then_some(&self.other),
        ]
    }
}

fn read_unwritten(casts: &[Cast], images: &[GpuImage]) -> Vec<(Format, TextureView)> {
    let mut out = Vec::new();
    for (i, cast) in casts.iter().enumerate() {
        let (CastMode::DepthPeel(other) | CastMode::StencilDepthFail { depth: other }) = cast.mode
        else {
            continue;
        };
        if !casts[..i]
            .iter()
            .any(|c| (c.image, c.layer) == (other, cast.layer))
        {
            let image = &images[other];
            out.push((image.desc.format, image.layers[cast.layer as usize].clone()));
        }
    }
    out
}
