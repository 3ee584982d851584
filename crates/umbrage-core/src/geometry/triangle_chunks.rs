//! Boxes around runs of triangles, so that whole runs can be passed over.

use crate::{Aabb, Geometry};
use std::ops::Range;

/// Triangles a box. Runs are in the order of the list, which meshes give some locality; fewer make more boxes to test, more
/// make them looser.
const RUN: u32 = 64;

/// Boxes around every 64 triangles of a geometry's list.
#[derive(Clone, Debug)]
pub(crate) struct ChunkBounds(Vec<Aabb>);

impl ChunkBounds {
    pub(crate) fn new(geometry: &Geometry) -> Self {
        let count = geometry.triangles().len() as u32;
        let box_of =
            |first: u32| Aabb::around(geometry.vertices_of(first..(first + RUN).min(count)));
        Self((0..count).step_by(RUN as usize).map(box_of).collect())
    }

    /// The runs that a range of triangles consists of. At its ends, boxes may be larger than their runs.
    pub(crate) fn of(
        &self,
        triangles: Range<u32>,
    ) -> impl Iterator<Item = (Range<u32>, Aabb)> + '_ {
        let runs = if triangles.is_empty() {
            0..0
        } else {
            triangles.start / RUN..(triangles.end - 1) / RUN + 1
        };
        runs.map(move |i| {
            let run = (i * RUN).max(triangles.start)..((i + 1) * RUN).min(triangles.end);
            (run, self.0[i as usize])
        })
    }
}
