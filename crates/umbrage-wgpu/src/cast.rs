//! The cast stage: draws triangles into every light space.

use crate::{
    filter::clear,
    resources::{
        bindings::{Binding, Bound},
        counters::ResourceFactory,
        cut_outs::{CutOutBinding, FrameWithHoles, GpuCutOuts},
        draws::{Draw, DrawList},
        faces::FaceBuffers,
        images::GpuImage,
        matrices::Matrices,
        pipelines::{PEELED_SLOT, Pipelines, Vertex},
        timestamps::{PassTimestamps, TimedStage, pass_stamps},
    },
    targets::CastTarget,
};
use umbrage_core::{Cast, CastMode, Format, Source};
use wgpu::{
    CommandEncoder, RenderPass, RenderPassDescriptor, RenderPipeline, ShaderStages, TextureView,
};

/// All casts of a recipe, prepared for encoding.
#[derive(Debug, Default)]
pub(crate) struct CastStage {
    pub(crate) targets: Vec<CastTarget>,
    /// For each target, whether it draws a technique's faces.
    faces: Vec<bool>,
    list: DrawList,
    /// Pipelines, for each target and each of its draws.
    pipelines: Vec<Vec<RenderPipeline>>,
    /// For each target, the layer that it peels.
    peeled: Vec<Binding>,
    /// Layers that casts read before any cast writes them.
    clears: Vec<(Format, TextureView)>,
    bindings: CastBindings,
    /// World from local of each draw.
    places: Matrices,
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
        self.bindings
            .write(factory, pipelines, self.targets.iter(), frame.holes);
        self.places.write(factory, pipelines, self.list.places());
        self.peeled
            .resize_with(self.targets.len(), Binding::default);
        for (peeled, target) in self.peeled.iter_mut().zip(&self.targets) {
            bind_peeled(peeled, factory, pipelines, target);
        }
        self.pipelines.clear();
        for (target, part) in self.targets.iter().zip(&self.list.casts) {
            let draws = self.list.draws[part.clone()].iter();
            let pipeline = |draw: &Draw| pipelines.cast(factory, target, draw.layout, draw.vertex);
            self.pipelines.push(draws.map(pipeline).collect());
        }
    }

    /// Returns whether a caller can draw the casts with only their targets: none peels, counts or
    /// draws a technique's faces.
    pub(crate) fn are_plain(&self) -> bool {
        let draws_faces = self.faces.contains(&true);
        let targets_are_plain = self
            .targets
            .iter()
            .all(|target| target.behind.is_none() && target.format().is_depth());
        targets_are_plain && !draws_faces
    }

    /// Returns whether a cast draws a technique's faces.
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

    /// Records one cast, without clearing the layers that it reads.
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
        self.bindings.bind(&mut pass, i, &self.peeled[i]);
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
                self.bindings.bind_holes(pass, cast);
            }
            draw.encode(pass);
        }
    }
}

/// Shader bindings of some casts: clip from world and, for alpha-tested triangles, the rays through
/// texels.
#[derive(Debug, Default)]
pub(crate) struct CastBindings {
    spaces: Matrices,
    holes: CutOutBinding,
}

impl CastBindings {
    /// Writes what the casts with these targets bind. Returns the number of written bytes.
    pub(crate) fn write<'t>(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        pipelines: &mut Pipelines,
        targets: impl Iterator<Item = &'t CastTarget> + Clone,
        holes: Option<&GpuCutOuts>,
    ) -> u64 {
        let spaces = targets.clone().map(|target| target.clip_from_world);
        let mut written = self.spaces.write(factory, pipelines, spaces);
        if let Some(holes) = holes {
            let rays = targets.map(CastTarget::rays);
            written += self.holes.write(factory, pipelines, holes, rays);
        }
        written
    }

    /// Binds the resources of all draws of a cast.
    pub(crate) fn bind(&self, pass: &mut RenderPass<'_>, cast: usize, peeled: &Binding) {
        self.spaces.bind(pass, 0, cast);
        if peeled.group().is_some() {
            pass.set_bind_group(2, peeled.group(), &[]);
        }
    }

    /// Binds the resources of draws of alpha-tested triangles.
    pub(crate) fn bind_holes(&self, pass: &mut RenderPass<'_>, cast: usize) {
        self.holes.bind(pass, 1, cast);
    }
}

/// Binds the layer that a cast peels, if any.
pub(crate) fn bind_peeled(
    peeled: &mut Binding,
    factory: &mut ResourceFactory<'_>,
    pipelines: &mut Pipelines,
    target: &CastTarget,
) {
    let Some(other) = &target.behind else {
        *peeled = Binding::default();
        return;
    };
    let layouts = &mut pipelines.layouts;
    let stage = ShaderStages::FRAGMENT;
    let entries = vec![(PEELED_SLOT, Bound::View(other.clone()))];
    peeled.bind(factory, layouts, stage, "umbrage peeled layer", entries);
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
