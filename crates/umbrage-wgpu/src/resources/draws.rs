//! Draws of all casts of a recipe, in one list.

use crate::{
    frame::{Drawable, PositionFormat, VertexLayout},
    resources::{
        counters::ResourceFactory,
        cut_outs::{FrameWithHoles, GpuCutOuts},
        faces::{FaceBuffer, FaceBuffers},
        pipelines::Vertex,
    },
};
use glam::{Affine3A, Mat4};
use std::ops::Range;
use umbrage_core::{Cast, Source};
use wgpu::{Buffer, IndexFormat, RenderPass};

/// An owned drawable.
#[derive(Debug)]
pub(crate) struct Draw {
    /// `None` if the vertex shader reads the geometry's lists itself.
    vertices: Option<Buffer>,
    indices: Option<(Buffer, IndexFormat)>,
    /// Ranges of indices, or of vertices if there are no indices.
    ranges: Vec<Range<u32>>,
    pub(crate) layout: VertexLayout,
    pub(crate) vertex: Vertex,
    world_from_local: Option<Affine3A>,
}

/// Draws of each cast.
#[derive(Debug, Default)]
pub(crate) struct DrawList {
    pub(crate) draws: Vec<Draw>,
    /// Range in the list for each cast.
    pub(crate) casts: Vec<Range<usize>>,
}

impl DrawList {
    pub(crate) fn new(
        factory: &mut ResourceFactory<'_>,
        faces: &mut FaceBuffers,
        casts: &[Cast],
        frame: FrameWithHoles<'_>,
    ) -> Self {
        let FrameWithHoles {
            inputs: frame,
            holes,
        } = frame;
        // Append the draws that all casts share.
        let mut draws = Vec::new();
        let casters_with_holes =
            holes.and_then(|holes| Draw::with_holes(holes, std::slice::from_ref(&holes.casters)));
        let casters = append(&mut draws, frame.casters, casters_with_holes);
        let uses_everything = casts.iter().any(|c| matches!(c.source, Source::Everything));
        let everything = if uses_everything {
            let all_with_holes = holes.and_then(|holes| {
                let everything = 0..holes.triangles;
                Draw::with_holes(holes, std::slice::from_ref(&everything))
            });
            append(&mut draws, frame.everything, all_with_holes)
        } else {
            0..0
        };
        // Append the draws of single casts.
        let mut ranges = Vec::with_capacity(casts.len());
        for cast in casts {
            let first = draws.len();
            let range = match &cast.source {
                Source::Casters => casters.clone(),
                Source::Everything => everything.clone(),
                Source::SomeCasters(runs) => {
                    draws.extend(frame.casters.iter().filter_map(|d| Draw::some(d, runs)));
                    draws.extend(holes.and_then(|holes| {
                        Draw::with_holes(holes, &runs_within(runs, &holes.casters))
                    }));
                    first..draws.len()
                }
                Source::Faces(drawn) => {
                    let buffer = faces.get(factory, drawn);
                    if !drawn.triangles.is_empty() {
                        draws.push(Draw::faces(buffer, drawn.triangles.len()));
                    }
                    first..draws.len()
                }
            };
            ranges.push(range);
        }
        Self {
            draws,
            casts: ranges,
        }
    }

    /// Returns the world from local of each draw.
    pub(crate) fn places(&self) -> impl Iterator<Item = Mat4> + '_ {
        self.draws
            .iter()
            .map(|d| d.world_from_local.map_or(Mat4::IDENTITY, Mat4::from))
    }
}

/// Appends the draws of all drawables that are not empty, and that of alpha-tested triangles.
/// Returns their range in the list.
fn append(
    draws: &mut Vec<Draw>,
    drawables: &[Drawable<'_>],
    with_holes: Option<Draw>,
) -> Range<usize> {
    let first = draws.len();
    draws.extend(
        drawables
            .iter()
            .filter(|d| !d.range.is_empty())
            .map(Draw::new),
    );
    draws.extend(with_holes);
    first..draws.len()
}

impl Draw {
    fn new(drawable: &Drawable<'_>) -> Self {
        Self {
            vertices: Some(drawable.vertices.clone()),
            indices: drawable.indices.map(|i| (i.buffer.clone(), i.format)),
            ranges: Vec::from([drawable.range.clone()]),
            layout: drawable.layout,
            vertex: match drawable.world_from_local {
                Some(_) => Vertex::Local,
                None => Vertex::World,
            },
            world_from_local: drawable.world_from_local,
        }
    }

    /// Returns the draw of the triangles of a drawable that are in `runs`, or of all if their ids
    /// are unknown; `None` if there is nothing to draw.
    fn some(drawable: &Drawable<'_>, runs: &[Range<u32>]) -> Option<Self> {
        let mut draw = Self::new(drawable);
        if let Some(triangles) = &drawable.triangles {
            draw.ranges = ranges_of(drawable.range.start, triangles, runs);
        }
        let is_empty = draw.ranges.iter().all(Range::is_empty);
        (!is_empty).then_some(draw)
    }

    /// Returns the draw of the alpha-tested triangles in runs; `None` if there are none.
    fn with_holes(holes: &GpuCutOuts, runs: &[Range<u32>]) -> Option<Self> {
        let [_, cut_out] = holes.cut_outs.split(runs);
        let ranges = cut_out.iter().map(|run| 3 * run.start..3 * run.end);
        let draw = Self {
            vertices: None,
            indices: None,
            ranges: ranges.collect(),
            layout: VertexLayout::PACKED,
            vertex: Vertex::CutOut(holes.rule()),
            world_from_local: None,
        };
        (!draw.ranges.is_empty()).then_some(draw)
    }

    fn faces(buffer: FaceBuffer, triangles: usize) -> Self {
        Self {
            vertices: Some(buffer.vertices),
            indices: Some((buffer.indices, IndexFormat::Uint32)),
            ranges: std::iter::once(0..3 * triangles as u32).collect(),
            layout: VertexLayout {
                // Not read: faces have four components.
                format: PositionFormat::Float32x3,
                stride: 16,
                position_offset: 0,
            },
            vertex: Vertex::Homogeneous,
            world_from_local: None,
        }
    }

    pub(crate) fn encode(&self, pass: &mut RenderPass<'_>) {
        if let Some(vertices) = &self.vertices {
            pass.set_vertex_buffer(0, vertices.slice(..));
        }
        if let Some((buffer, format)) = &self.indices {
            pass.set_index_buffer(buffer.slice(..), *format);
        }
        for range in &self.ranges {
            match self.indices {
                Some(_) => pass.draw_indexed(range.clone(), 0, 0..1),
                None => pass.draw(range.clone(), 0..1),
            }
        }
    }
}

/// Returns the parts of runs within a range.
fn runs_within(runs: &[Range<u32>], range: &Range<u32>) -> Vec<Range<u32>> {
    let clipped = |run: &Range<u32>| run.start.max(range.start)..run.end.min(range.end);
    runs.iter()
        .map(clipped)
        .filter(|run| !run.is_empty())
        .collect()
}

/// Returns the ranges of indices that draw the part of `runs` in `triangles`. `first` is the index
/// of the first corner of these triangles.
fn ranges_of(first: u32, triangles: &Range<u32>, runs: &[Range<u32>]) -> Vec<Range<u32>> {
    let mut ranges = Vec::new();
    for run in runs {
        let start = run.start.max(triangles.start);
        let end = run.end.min(triangles.end);
        if start < end {
            let corner = |triangle: u32| first + 3 * (triangle - triangles.start);
            ranges.push(corner(start)..corner(end));
        }
    }
    ranges
}

#[cfg(test)]
mod tests {
    use super::{ranges_of, runs_within};

    #[test]
    fn runs_become_ranges_of_indices() {
        let runs = [0..4, 10..12, 15..40];
        assert_eq!(ranges_of(300, &(10..20), &runs), [300..306, 315..330]);
        assert_eq!(ranges_of(0, &(0..40), &runs), [0..12, 30..36, 45..120]);
        assert_eq!(ranges_of(0, &(4..10), &runs), []);
    }

    #[test]
    fn runs_beyond_a_range_are_none() {
        let runs = [0..4, 10..12, 19..30, 30..40];
        assert_eq!(runs_within(&runs, &(2..20)), [2..4, 10..12, 19..20]);
    }
}
