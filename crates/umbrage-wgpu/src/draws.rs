//! All that a recipe's casts draw, in the order of one list.

use crate::{
    counters::Maker,
    faces::FaceBuffers,
    frame::{Drawable, Frame, VertexLayout},
};
use glam::{Affine3A, Mat4};
use std::ops::Range;
use umbrage_core::{Cast, Source};
use wgpu::{Buffer, IndexFormat, RenderPass};

/// A drawable that outlives the borrow.
#[derive(Debug)]
pub(crate) struct Draw {
    vertices: Buffer,
    indices: Option<(Buffer, IndexFormat)>,
    range: Range<u32>,
    pub(crate) layout: VertexLayout,
    pub(crate) vertex: Vertex,
    world_from_local: Option<Affine3A>,
}

/// How a vertex tells its position.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Vertex {
    /// Three floats in world space.
    World,
    /// Three floats, to be placed into the world.
    Local,
    /// Four floats in world space.
    Homogeneous,
}

/// What each cast draws.
#[derive(Debug, Default)]
pub(crate) struct DrawList {
    pub(crate) draws: Vec<Draw>,
    /// For each cast, its part of the list.
    pub(crate) casts: Vec<Range<usize>>,
}

impl DrawList {
    pub(crate) fn new(
        maker: &mut Maker<'_>,
        faces: &mut FaceBuffers,
        casts: &[Cast],
        frame: &Frame<'_>,
    ) -> Self {
        let mut draws = Vec::new();
        let casters = append(&mut draws, frame.casters);
        let uses_everything = casts.iter().any(|c| matches!(c.source, Source::Everything));
        let everything = append(
            &mut draws,
            if uses_everything {
                frame.everything
            } else {
                &[]
            },
        );
        let mut part = |cast: &Cast| match &cast.source {
            Source::Casters => casters.clone(),
            Source::Everything => everything.clone(),
            Source::Faces(drawn) => {
                let buffers = faces.get(maker, drawn);
                let first = draws.len();
                draws.extend(
                    (!drawn.triangles.is_empty())
                        .then(|| Draw::faces(buffers, drawn.triangles.len())),
                );
                first..draws.len()
            }
        };
        let casts = casts.iter().map(&mut part).collect();
        Self { draws, casts }
    }

    /// Where each draw's vertices are to be placed.
    pub(crate) fn places(&self) -> impl Iterator<Item = Mat4> + '_ {
        self.draws
            .iter()
            .map(|d| d.world_from_local.map_or(Mat4::IDENTITY, Mat4::from))
    }
}

fn append(draws: &mut Vec<Draw>, drawables: &[Drawable<'_>]) -> Range<usize> {
    let first = draws.len();
    draws.extend(
        drawables
            .iter()
            .filter(|d| !d.range.is_empty())
            .map(Draw::new),
    );
    first..draws.len()
}

impl Draw {
    fn new(drawable: &Drawable<'_>) -> Self {
        Self {
            vertices: drawable.vertices.clone(),
            indices: drawable.indices.map(|i| (i.buffer.clone(), i.format)),
            range: drawable.range.clone(),
            layout: drawable.layout,
            vertex: if drawable.world_from_local.is_some() {
                Vertex::Local
            } else {
                Vertex::World
            },
            world_from_local: drawable.world_from_local,
        }
    }

    fn faces([vertices, indices]: [Buffer; 2], triangles: usize) -> Self {
        Self {
            vertices,
            indices: Some((indices, IndexFormat::Uint32)),
            range: 0..3 * triangles as u32,
            layout: VertexLayout {
                stride: 16,
                position_offset: 0,
            },
            vertex: Vertex::Homogeneous,
            world_from_local: None,
        }
    }

    pub(crate) fn encode(&self, pass: &mut RenderPass<'_>) {
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        match &self.indices {
            Some((buffer, format)) => {
                pass.set_index_buffer(buffer.slice(..), *format);
                pass.draw_indexed(self.range.clone(), 0, 0..1);
            }
            None => pass.draw(self.range.clone(), 0..1),
        }
    }
}
