//! The cast stage: triangles into every light space.

use crate::{
    filter::clear,
    resources::{
        bindings::{Binding, Bound, Slot},
        counters::ResourceFactory,
        cut_outs::{CutOutBinding, FrameWithHoles, cut_out_layout},
        draws::DrawList,
        faces::FaceBuffers,
        images::GpuImage,
        matrices::{Matrices, matrix_layout},
        pipelines::{CastKey, Peel, Pipelines, Vertex},
        timestamps::{PassTimestamps, TimedStage, pass_stamps},
    },
    targets::CastTarget,
};
use umbrage_core::{Cast, CastMode, Format, Source};
use wgpu::{
    BindGroupLayout, CommandEncoder, RenderPass, RenderPassDescriptor, RenderPipeline,
    ShaderStages, TextureView,
};

/// All of a recipe's casts, ready to be encoded.
#[derive(Debug, Default)]
pub(crate) struct CastStage {
    pub(crate) targets: Vec<CastTarget>,
    /// For each target, whether it draws faces that the technique made.
    faces: Vec<bool>,
    list: DrawList,
    /// For each target, and in it for each draw.
    pipelines: Vec<Vec<RenderPipeline>>,
    /// For each target, the layer that it peels off.
    peeled: Vec<Binding>,
    /// Layers that casts read before any cast writes them.
    clears: Vec<(Format, TextureView)>,
    /// Each target's clip from world.
    spaces: Matrices,
    /// Each draw's world from local.
    places: Matrices,
    /// What draws of triangles with holes read; each target's rays.
    holes: CutOutBinding,
}

impl CastStage {
    pub(crate) fn prepare(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        casts: &[Cast],
        images: &[GpuImage],
        faces: &mut FaceBuffers,
        frame: FrameWithHoles<'_>,
    ) {
        self.targets = (0..casts.len())
            .map(|i| CastTarget::new(casts, i, images))
            .collect();
        self.faces = casts
            .iter()
            .map(|c| matches!(c.source, Source::Faces(_)))
            .collect();
        self.list = DrawList::new(factory, faces, casts, frame);
        self.clears = read_unwritten(casts, images);
        self.spaces.write(
            factory,
            pipelines,
            self.targets.iter().map(|t| t.clip_from_world),
        );
        self.places.write(factory, pipelines, self.list.places());
        let mut layouts = Layouts::new(factory, pipelines);
        if let Some(holes) = frame.holes {
            let layout = cut_out_layout(factory, pipelines, holes.rule());
            let rays = casts
                .iter()
                .map(|cast| cast.space.rays(images[cast.image].desc.size));
            self.holes.write(factory, &layout, holes, rays);
            layouts.cut_outs = Some(layout);
        }
        self.bind_peeled(factory, &layouts);
        self.pipelines.clear();
        for (target, part) in self.targets.iter().zip(&self.list.casts) {
            let mut of_target = Vec::new();
            for draw in &self.list.draws[part.clone()] {
                let key = CastKey {
                    depth: target.state(),
                    layout: draw.layout,
                    vertex: draw.vertex,
                    peel: Peel::of(target),
                };
                of_target.push(pipelines.cast(factory, key, &layouts.of(&key)));
            }
            self.pipelines.push(of_target);
        }
    }

    fn bind_peeled(&mut self, factory: &mut ResourceFactory<'_>, layouts: &Layouts) {
        self.peeled
            .resize_with(self.targets.len(), Binding::default);
        for (binding, target) in self.peeled.iter_mut().zip(&self.targets) {
            if let Some(other) = &target.behind {
                binding.set(
                    factory,
                    "umbrage peeled layer",
                    &layouts.peeled,
                    vec![Bound::View(other.clone())],
                );
            }
        }
    }

    /// Returns whether a caller can draw the casts with their targets alone: none peels, counts or draws the technique's faces.
    pub(crate) fn are_plain(&self) -> bool {
        let draws_faces = self.faces.contains(&true);
        let targets_are_plain = self
            .targets
            .iter()
            .all(|target| target.behind.is_none() && target.format().is_depth());
        targets_are_plain && !draws_faces
    }

    /// Returns whether a cast draws faces that the technique made.
    pub(crate) fn draws_faces(&self, cast: usize) -> bool {
        self.faces[cast]
    }

    /// Clears the layers that casts read before any cast writes them.
    pub(crate) fn clear(&self, encoder: &mut CommandEncoder) {
        for (format, view) in &self.clears {
            clear(encoder, *format, view);
        }
    }

    pub(crate) fn encode(&self, encoder: &mut CommandEncoder, stamps: Option<&PassTimestamps<'_>>) {
        self.clear(encoder);
        for i in 0..self.targets.len() {
            self.encode_one(encoder, i, stamps);
        }
    }

    /// Records one cast, without clearing what it reads.
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
            pass.set_bind_group(2, self.peeled[i].group(), &[]);
        }
        self.draw(&mut pass, i);
    }

    fn draw(&self, pass: &mut RenderPass<'_>, cast: usize) {
        let mut last = None;
        for (index, pipeline) in self.list.casts[cast].clone().zip(&self.pipelines[cast]) {
            let draw = &self.list.draws[index];
            if last != Some(pipeline) {
                pass.set_pipeline(pipeline);
                last = Some(pipeline);
            }
            if draw.vertex == Vertex::Local {
                self.places.bind(pass, 1, index);
            }
            if matches!(draw.vertex, Vertex::CutOut(_)) {
                self.holes.bind(pass, 1, cast);
            }
            draw.encode(pass);
        }
    }
}

/// Layouts of the bind groups of casts: 0 holds clip from world, 1 world from local or what tells holes, 2 the layer that is peeled
/// off.
#[derive(Debug)]
pub(crate) struct Layouts {
    matrix: BindGroupLayout,
    pub(crate) peeled: BindGroupLayout,
    /// Where triangles have holes.
    pub(crate) cut_outs: Option<BindGroupLayout>,
}

impl Layouts {
    pub(crate) fn new(factory: &ResourceFactory<'_>, pipelines: &mut Pipelines) -> Self {
        let matrix = matrix_layout(factory, pipelines);
        let peeled = pipelines.layouts.get(
            factory,
            ShaderStages::FRAGMENT,
            &[Slot::Floats { layered: false }],
        );
        Self {
            matrix,
            peeled,
            cut_outs: None,
        }
    }

    pub(crate) fn of(&self, key: &CastKey) -> [Option<&BindGroupLayout>; 3] {
        let second = match key.vertex {
            Vertex::Local => Some(&self.matrix),
            Vertex::CutOut(_) => self.cut_outs.as_ref(),
            Vertex::World | Vertex::Instanced | Vertex::Homogeneous => None,
        };
        let peeled = (key.peel != Peel::Nothing).then_some(&self.peeled);
        [Some(&self.matrix), second, peeled]
    }
}

/// Returns the layers that casts read before any cast writes them, with their formats.
fn read_unwritten(casts: &[Cast], images: &[GpuImage]) -> Vec<(Format, TextureView)> {
    let mut out = Vec::new();
    for (i, cast) in casts.iter().enumerate() {
        let read = match cast.mode {
            CastMode::Depth => continue,
            CastMode::DepthPeel(other) => other,
            CastMode::StencilDepthFail { depth } => depth,
        };
        let is_written = casts[..i]
            .iter()
            .any(|earlier| earlier.image == read && earlier.layer == cast.layer);
        if !is_written {
            let image = &images[read];
            out.push((image.desc.format, image.layers[cast.layer as usize].clone()));
        }
    }
    out
}
