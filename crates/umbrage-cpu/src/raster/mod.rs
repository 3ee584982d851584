//! Rasteriser: draws triangles into depth (and id) images, bit-equal to Mesa's software
//! rasterisers.

mod bin;
mod clip;
mod clipping;
mod fill;
mod holes;
mod mode;
#[cfg(test)]
mod mode_tests;
mod plane_error;
mod position;
mod record;
#[cfg(test)]
mod reference;
mod setup;
#[cfg(test)]
mod tests;
mod tile;
mod viewport;
mod whole;

pub(crate) use crate::raster::position::Position;
pub(crate) use crate::raster::tile::Target;
pub use crate::raster::{clipping::Clipping, plane_error::PlaneShift, position::VertexSums};
pub(crate) use crate::raster::{holes::Holes, mode::Mode};

use crate::raster::{
    bin::{Bins, FETCH, TILE},
    clip::{clip, is_culled, outcode},
    fill::{Canvas, fill},
    holes::{HoleTest, NoHoles},
    mode::{Depth, Depth16, DepthOp, DepthPeel, DepthPeel16, DepthWithIds, StencilDepthFail},
    record::Record,
    setup::{Group, SetupRules},
    tile::{Tile, TileBuffer},
    viewport::Viewport,
    whole::Whole,
};
use glam::{Mat4, UVec2, Vec3, Vec4};
use rayon::prelude::*;
use umbrage_core::{Cull, DepthPlanes, RasterBias, Simd, SimdTask, Snapping};

/// Number of triangles that one task sets up.
const CHUNK: usize = 4096;

/// Triangles to draw, with the parameters of the draw.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Draw<'a, P = Vec3> {
    /// World-space vertices.
    pub(crate) positions: &'a [P],
    /// Vertex indices.
    pub(crate) triangles: &'a [[u32; 3]],
    /// Id of the first triangle; the others follow.
    pub(crate) first_id: u32,
    /// Matrix from world to clip space.
    pub(crate) clip_from_world: Mat4,
    /// Image size, pixels.
    pub(crate) size: UVec2,
    /// Faces to cull.
    pub(crate) cull: Cull,
    /// Polygon offset.
    pub(crate) bias: RasterBias,
    /// Test and update of the image.
    pub(crate) mode: Mode,
    /// Instructions that loops are compiled for.
    pub(crate) simd: Simd,
    /// Alpha test of the triangles, whose ids are those of its geometry; ignored by modes that
    /// count.
    pub(crate) holes: Option<Holes<'a>>,
}

/// Vertex in the window, with the set of planes of the view volume that it is outside of.
#[derive(Clone, Copy, Debug, Default)]
struct Vertex {
    window: Vec3,
    outcode: u32,
}

impl Vertex {
    #[inline(always)]
    fn new(clip: Vec4, viewport: &Viewport) -> Self {
        Self {
            window: viewport.project(clip),
            outcode: outcode(clip),
        }
    }
}

/// Buffers of a thread for setting up a chunk.
#[derive(Debug, Default)]
struct Worker {
    vertices: Vec<Vertex>,
    bins: Bins,
}

/// Rounding of a rasteriser.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Rounding {
    /// Rounding of vertices, depth planes and units of polygon offset.
    pub(crate) snapping: Snapping,
    /// Shift of the triangles' depths.
    pub(crate) plane_shift: PlaneShift,
    /// Clipping of triangles.
    pub(crate) clipping: Clipping,
    /// Order of sums in the transform of vertices.
    pub(crate) vertex_sums: VertexSums,
}

/// Rasteriser with its working memory, which is kept between uses. One set of chunks is filled
/// while the next is set up.
#[derive(Debug, Default)]
pub(crate) struct Rasterizer {
    /// Rounding.
    pub(crate) rounding: Rounding,
    filled: Vec<Worker>,
    set_up: Vec<Worker>,
}

impl Rasterizer {
    /// Returns a rasteriser with this rounding.
    pub(crate) fn new(rounding: Rounding) -> Self {
        Self {
            rounding,
            ..Self::default()
        }
    }

    /// Draws into the target.
    pub(crate) fn draw<P: Position>(&mut self, draw: &Draw<'_, P>, target: Target<'_>) {
        let rounding = self.rounding;
        let filling = Filling {
            mode: draw.mode,
            simd: draw.simd,
            columns: target.width.div_ceil(TILE),
            holes: draw.holes,
        };
        // Fill each batch while the next is set up.
        let mut tiles = target.into_tiles(draw.mode);
        let batch = self.prepare(draw.size);
        let mut ready = 0;
        for (i, triangles) in draw.triangles.chunks(batch).enumerate() {
            let draw = Draw {
                triangles,
                first_id: draw.first_id + (i * batch) as u32,
                ..*draw
            };
            let next = triangles.len().div_ceil(CHUNK);
            rayon::join(
                || fill_tiles(&mut tiles, &self.filled[..ready], filling),
                || set_up(&draw, rounding, &mut self.set_up[..next]),
            );
            std::mem::swap(&mut self.filled, &mut self.set_up);
            ready = next;
        }
        fill_tiles(&mut tiles, &self.filled[..ready], filling);
        tiles.par_iter_mut().for_each(Tile::finish);
    }

    /// Returns the number of triangles in a batch. It keeps working memory well below the image's.
    /// It is at most some tens of thousands (more only with many threads), which fit the
    /// processor's caches.
    fn prepare(&mut self, size: UVec2) -> usize {
        let pixels = size.x as usize * size.y as usize;
        let most = (2 * rayon::current_num_threads()).max(16);
        let chunks = (pixels / (64 * CHUNK)).clamp(1, most);
        for workers in [&mut self.filled, &mut self.set_up] {
            workers.resize_with(chunks.max(workers.len()), Worker::default);
        }
        chunks * CHUNK
    }

    /// Returns the bytes of working memory.
    pub(crate) fn bytes(&self) -> usize {
        let of = |w: &Worker| w.vertices.capacity() * size_of::<Vertex>() + w.bins.bytes();
        self.filled.iter().chain(&self.set_up).map(of).sum()
    }
}

/// Sets up a batch, one chunk per worker.
fn set_up<P: Position>(draw: &Draw<'_, P>, rounding: Rounding, workers: &mut [Worker]) {
    let parts = draw.triangles.par_chunks(CHUNK).zip(workers).enumerate();
    parts.for_each(|(k, (triangles, worker))| {
        let first_id = draw.first_id + (k * CHUNK) as u32;
        draw.simd.run_task(SetUp {
            worker,
            rounding,
            draw: Draw {
                triangles,
                first_id,
                ..*draw
            },
        });
    });
}

/// Parameters for filling tiles.
#[derive(Clone, Copy)]
struct Filling<'a> {
    mode: Mode,
    simd: Simd,
    /// Tiles in a row.
    columns: usize,
    holes: Option<Holes<'a>>,
}

fn fill_tiles(tiles: &mut [Tile<'_>], workers: &[Worker], filling: Filling<'_>) {
    if workers.is_empty() {
        return;
    }
    let each = tiles.par_iter_mut().enumerate();
    each.for_each_init(
        || TileBuffer::new(filling.mode),
        |buffer, (i, tile)| {
            if workers.iter().all(|w| w.bins.count(i) == 0) {
                return;
            }
            tile.load(buffer);
            filling.simd.run_task(FillTile {
                buffer,
                workers,
                tile: i,
                filling,
            });
            tile.store(buffer);
        },
    );
}

/// Task that sets up one chunk.
struct SetUp<'a, P> {
    worker: &'a mut Worker,
    rounding: Rounding,
    draw: Draw<'a, P>,
}

impl<P: Position> SimdTask for SetUp<'_, P> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.worker.set_up(&self.draw, self.rounding);
    }
}

/// Task that fills one tile.
struct FillTile<'a> {
    buffer: &'a mut TileBuffer,
    workers: &'a [Worker],
    tile: usize,
    filling: Filling<'a>,
}

impl SimdTask for FillTile<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        match self.filling.holes {
            None => self.fill_by_mode(&NoHoles),
            Some(holes) => self.fill_by_mode(&holes),
        }
    }
}

impl FillTile<'_> {
    #[inline(always)]
    fn fill_by_mode<C: HoleTest>(self, holes: &C) {
        match self.filling.mode {
            Mode::Depth => self.fill_all::<Depth, C>(holes),
            Mode::DepthWithIds => self.fill_all::<DepthWithIds, C>(holes),
            Mode::Depth16 => self.fill_all::<Depth16, C>(holes),
            Mode::DepthPeel => self.fill_all::<DepthPeel, C>(holes),
            Mode::DepthPeel16 => self.fill_all::<DepthPeel16, C>(holes),
            // Counts have no ids for an alpha test.
            Mode::StencilDepthFail => self.fill_all::<StencilDepthFail, NoHoles>(&NoHoles),
        }
    }

    #[inline(always)]
    fn fill_all<P: DepthOp, C: HoleTest>(self, holes: &C) {
        let columns = self.filling.columns;
        let origin = [self.tile % columns * TILE, self.tile / columns * TILE];
        let mut canvas = Canvas {
            buffer: self.buffer,
            origin: [origin[0] as i32, origin[1] as i32],
        };
        let mut fetched = [Record::default(); FETCH];
        for worker in self.workers {
            for numbers in worker.bins.of_tile(self.tile).chunks(FETCH) {
                for record in worker.bins.fetch(numbers, &mut fetched) {
                    fill::<P, C>(&mut canvas, record, holes);
                }
            }
        }
        P::finish_tile(canvas.buffer);
    }
}

impl Worker {
    /// Transforms, clips, sets up and sorts a chunk of triangles.
    #[inline(always)]
    fn set_up<P: Position>(&mut self, draw: &Draw<'_, P>, rounding: Rounding) {
        let viewport = Viewport::new(draw.size);
        let rules = SetupRules {
            size: draw.size,
            cull: draw.cull,
            bias: draw.bias,
            mode: draw.mode,
            rounding,
        };
        // Pieces of clipped triangles are culled twice on devices that don't snap their planes.
        let culls_twice = rounding.snapping.planes == DepthPlanes::Unsnapped;
        // Transform the vertices.
        let first = match rounding.vertex_sums {
            // Inlined, without a branch per vertex.
            VertexSums::InOrder => self.transform(draw, &viewport, P::to_clip),
            sums => self.transform(draw, &viewport, |p, m| p.to_clip_by(sums, m)),
        };
        let to_clip = |v: u32| {
            let position = draw.positions[v as usize];
            position.to_clip_by(rounding.vertex_sums, draw.clip_from_world)
        };
        let mut group = Group::new();
        self.bins.clear(draw.size);
        // Set up each triangle, and clip it if needed.
        for (i, indices) in draw.triangles.iter().enumerate() {
            let id = draw.first_id + i as u32;
            if rounding.clipping != Clipping::Exact {
                let corners = indices.map(to_clip);
                rounding
                    .clipping
                    .clip(corners, draw.size, &viewport, |piece| {
                        if let Some(whole) = Whole::through_corners(piece, rounding)
                            && let Some(piece) = whole.place(piece)
                        {
                            group.push(piece, id, &rules, &mut self.bins);
                            group.flush_pieces(&whole, &rules, &mut self.bins);
                        }
                    });
                continue;
            }
            let [a, b, c] = match first {
                Some(first) => [indices[0] - first, indices[1] - first, indices[2] - first],
                None => [3 * i as u32, 3 * i as u32 + 1, 3 * i as u32 + 2],
            };
            let (a, b, c) = (
                &self.vertices[a as usize],
                &self.vertices[b as usize],
                &self.vertices[c as usize],
            );
            let codes = [a.outcode, b.outcode, c.outcode];
            if codes[0] | codes[1] | codes[2] == 0 {
                group.push([a.window, b.window, c.window], id, &rules, &mut self.bins);
            } else if codes[0] & codes[1] & codes[2] == 0 {
                let triangle = indices.map(to_clip);
                let mask = codes[0] | codes[1] | codes[2];
                if let Some(whole) = Whole::new(triangle, &viewport, rounding) {
                    group.flush(&rules, &mut self.bins);
                    clip(triangle, mask, &viewport, |piece| {
                        if let Some(piece) = whole.place(piece) {
                            group.push(piece, id, &rules, &mut self.bins);
                        }
                    });
                    group.flush_pieces(&whole, &rules, &mut self.bins);
                } else {
                    clip(triangle, mask, &viewport, |piece| {
                        if !(culls_twice && is_culled(piece, draw.cull)) {
                            group.push(piece, id, &rules, &mut self.bins);
                        }
                    });
                }
            }
        }
        group.flush(&rules, &mut self.bins);
        self.bins.sort();
    }

    /// Transforms the chunk's vertices. Transforms the whole range from the least index to the
    /// greatest and returns the least one. If that would be wasteful, transforms each triangle's
    /// corners and returns `None`.
    #[inline(always)]
    fn transform<P: Position>(
        &mut self,
        draw: &Draw<'_, P>,
        viewport: &Viewport,
        to_clip: impl Fn(P, Mat4) -> Vec4,
    ) -> Option<u32> {
        let to_vertex = |p: P| Vertex::new(to_clip(p, draw.clip_from_world), viewport);
        let (mut least, mut greatest) = (u32::MAX, 0);
        for t in draw.triangles {
            least = least.min(t[0]).min(t[1]).min(t[2]);
            greatest = greatest.max(t[0]).max(t[1]).max(t[2]);
        }
        let range = least as usize..greatest as usize + 1;
        if range.len() <= 3 * draw.triangles.len() {
            self.vertices.resize(range.len(), Vertex::default());
            for (vertex, &p) in self.vertices.iter_mut().zip(&draw.positions[range]) {
                *vertex = to_vertex(p);
            }
            return Some(least);
        }
        self.vertices
            .resize(3 * draw.triangles.len(), Vertex::default());
        for (vertex, &v) in self.vertices.iter_mut().zip(draw.triangles.as_flattened()) {
            *vertex = to_vertex(draw.positions[v as usize]);
        }
        None
    }
}
