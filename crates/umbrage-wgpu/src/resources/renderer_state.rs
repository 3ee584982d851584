//! GPU objects of one light's shadows, in use from `prepare` until the recorded commands of
//! `encode` are submitted.

use crate::{
    cast::CastStage,
    filter::FilterStage,
    frame::RendererOptions,
    hierarchy::one::RecipeHierarchy,
    receive::PixelStage,
    resources::{
        counters::ResourceFactory,
        counts::CountingPair,
        cut_outs::FrameWithHoles,
        faces::FaceBuffers,
        images::{GpuImage, fit_images},
        kernel_stage::Sources,
        pipelines::Pipelines,
        submissions::Pending,
        tables::Tables,
        timestamps::{PassTimestamps, TimedStage, of_compute, pass_stamps},
    },
};
use glam::UVec2;
use std::sync::Arc;
use umbrage_core::{Faces, ImageDesc, Recipe, Source};
use wgpu::{CommandEncoder, TextureView};

/// Resources shared by all lights.
#[derive(Debug, Default)]
pub(crate) struct Shared {
    pub(crate) pipelines: Pipelines,
    pub(crate) tables: Tables,
    pub(crate) faces: FaceBuffers,
}

/// Textures, uniforms and bind groups of one light. They are rewritten only after all commands that
/// read them are submitted.
#[derive(Debug, Default)]
pub(crate) struct Resources {
    pub(crate) images: Vec<GpuImage>,
    pub(crate) casts: CastStage,
    pub(crate) hierarchy: RecipeHierarchy,
    pub(crate) filters: FilterStage,
    pub(crate) receive: PixelStage,
    pub(crate) shading: PixelStage,
    pub(crate) pending: Pending,
    /// Faces drawn by casts, held so that their buffers are not reused.
    faces: Vec<Arc<Faces>>,
}

impl Resources {
    pub(crate) fn prepare(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        shared: &mut Shared,
        options: RendererOptions,
        recipe: &Recipe,
        pairs: &[CountingPair],
        frame: FrameWithHoles<'_>,
    ) {
        let Shared {
            pipelines,
            tables,
            faces,
        } = shared;
        let is_stored = |image| {
            let mut filters = recipe.filters.iter();
            filters.any(|filter| filter.output == image && filter.kernel.tile().is_some())
        };
        fit_images(factory, &mut self.images, &recipe.images, pairs, is_stored);
        self.casts.prepare(
            factory,
            pipelines,
            &recipe.casts,
            &self.images,
            faces,
            frame,
        );
        let inputs = frame.inputs;
        self.faces = recipe.casts.iter().filter_map(faces_of).collect();
        self.hierarchy.prepare(factory, pipelines, recipe);
        let mut sources = Sources {
            recipe,
            images: &self.images,
            tables,
            hierarchy: Some(&self.hierarchy),
        };
        self.filters.prepare(factory, pipelines, &mut sources);
        let receive = &mut self.receive;
        let mask = receive.prepare_receive(factory, pipelines, &mut sources, options, inputs);
        if let Some(mask) = mask {
            self.shading
                .prepare_shade(factory, pipelines, &mut sources, options, inputs, mask);
        }
    }

    /// Drops the faces, unless an unsubmitted encoder draws them.
    pub(crate) fn release(&mut self) {
        if self.pending.is_over() {
            self.faces.clear();
        }
    }

    /// Returns whether the existing textures match these images and a mask of this size.
    pub(crate) fn fits(&self, images: &[ImageDesc], mask: UVec2) -> bool {
        self.images.iter().map(|image| &image.desc).eq(images)
            && self
                .receive
                .image()
                .is_some_and(|held| held.desc.size == mask)
    }

    /// Records the passes that compute the kernel's inputs: the hierarchy and the filters.
    pub(crate) fn encode_inputs(
        &self,
        encoder: &mut CommandEncoder,
        stamps: Option<&PassTimestamps<'_>>,
    ) {
        self.filters.clear(encoder);
        // The hierarchy is the first pass of the stage.
        let earlier = usize::from(self.hierarchy.has_passes());
        let count = earlier + self.filters.pass_count();
        let stamps_of_hierarchy = pass_stamps(stamps, TimedStage::Filter, 0, count);
        self.hierarchy
            .encode(encoder, stamps_of_hierarchy.map(of_compute));
        self.filters.encode(encoder, stamps, earlier);
    }

    /// Records the receive stage and the shade pass. Returns the mask.
    pub(crate) fn encode_mask(
        &self,
        encoder: &mut CommandEncoder,
        options: RendererOptions,
        stamps: Option<&PassTimestamps<'_>>,
    ) -> Option<&TextureView> {
        let stamps = pass_stamps(stamps, TimedStage::Receive, 0, 1);
        let mask = self.receive.encode(encoder, options, stamps)?;
        self.shading.encode(encoder, options, None);
        Some(&mask.whole)
    }
}

fn faces_of(cast: &umbrage_core::Cast) -> Option<Arc<Faces>> {
    match &cast.source {
        Source::Faces(faces) => Some(faces.clone()),
        _ => None,
    }
}
