//! A geometry's triangles on the GPU.

use crate::{
    frame::{Drawable, Indices, VertexLayout},
    resources::{counters::ResourceFactory, cut_outs::GpuCutOuts},
};
use std::ops::Range;
use umbrage_core::{BackendError, Geometry, Invalid};
use wgpu::{Buffer, BufferUsages, IndexFormat};

/// Positions and indices. They are vertex and index buffers, and shaders read them to compute
/// receivers.
#[derive(Debug)]
pub(crate) struct GpuGeometry {
    fingerprint: u64,
    pub(crate) positions: Buffer,
    pub(crate) indices: Buffer,
    pub(crate) triangles: u32,
    casters: Range<u32>,
    /// Alpha-tested triangles; `None` if all are opaque.
    pub(crate) cut_outs: Option<GpuCutOuts>,
    pub(crate) receivers: Range<u32>,
}

impl GpuGeometry {
    pub(crate) fn upload(
        factory: &mut ResourceFactory<'_>,
        geometry: &Geometry,
    ) -> Result<Self, Invalid> {
        let positions: &[u8] = bytemuck::cast_slice(geometry.positions());
        let indices: &[u8] = bytemuck::cast_slice(geometry.triangles());
        let limits = factory.device.limits();
        let most = limits
            .max_storage_buffer_binding_size
            .min(limits.max_buffer_size);
        let rows: &[u8] = match geometry.cut_outs() {
            Some(cut_outs) => bytemuck::cast_slice(cut_outs.rows()),
            None => &[],
        };
        let coverage = geometry.cut_outs().and_then(|c| c.coverage_rows());
        let coverage: Option<&[u8]> = coverage.map(|rows| bytemuck::cast_slice(rows));
        // Check the sizes.
        let lists = [
            ("vertices", positions),
            ("triangles", indices),
            ("cut-outs", rows),
            ("mipmaps of alpha textures", coverage.unwrap_or_default()),
        ];
        for (what, bytes) in lists {
            let bytes = bytes.len() as u64;
            if bytes > most {
                let why = format!(
                    "take {bytes} bytes, and this graphics adapter supports at most {most}"
                );
                return Err(Invalid::new(
                    what,
                    why,
                    "use a smaller scene or the CPU backend",
                ));
            }
        }
        // Upload the lists.
        let vertex_usage = BufferUsages::VERTEX;
        let index_usage = BufferUsages::INDEX;
        let positions = upload(factory, "umbrage positions", vertex_usage, positions);
        let indices = upload(factory, "umbrage triangles", index_usage, indices);
        let triangles = geometry.triangles().len() as u32;
        let coverage =
            coverage.map(|rows| upload(factory, "umbrage coverages", BufferUsages::empty(), rows));
        let cut_outs = geometry.cut_outs().map(|cut_outs| GpuCutOuts {
            cut_outs: cut_outs.clone(),
            positions: positions.clone(),
            indices: indices.clone(),
            rows: upload(factory, "umbrage cut-outs", BufferUsages::empty(), rows),
            coverage,
            casters: geometry.casters(),
            triangles,
        });
        Ok(Self {
            fingerprint: geometry.fingerprint(),
            positions,
            indices,
            triangles,
            casters: geometry.casters(),
            cut_outs,
            receivers: geometry.receivers(),
        })
    }

    /// Returns the opaque casters.
    pub(crate) fn casters(&self) -> Vec<Drawable<'_>> {
        self.whole(&self.casters)
    }

    /// Returns all opaque triangles.
    pub(crate) fn everything(&self) -> Vec<Drawable<'_>> {
        self.whole(&(0..self.triangles))
    }

    fn whole(&self, triangles: &Range<u32>) -> Vec<Drawable<'_>> {
        let Some(holes) = &self.cut_outs else {
            return vec![self.drawable(triangles)];
        };
        let [whole, _] = holes.cut_outs.split(std::slice::from_ref(triangles));
        whole.iter().map(|run| self.drawable(run)).collect()
    }

    fn drawable(&self, triangles: &Range<u32>) -> Drawable<'_> {
        Drawable {
            vertices: &self.positions,
            layout: VertexLayout::PACKED,
            indices: Some(Indices {
                buffer: &self.indices,
                format: IndexFormat::Uint32,
            }),
            range: 3 * triangles.start..3 * triangles.end,
            world_from_local: None,
            triangles: Some(triangles.clone()),
        }
    }
}

/// Returns a buffer that contains the bytes and has storage usage.
fn upload(
    factory: &mut ResourceFactory<'_>,
    label: &str,
    usage: BufferUsages,
    bytes: &[u8],
) -> Buffer {
    // Storage bindings must not be empty.
    let size = (bytes.len() as u64).max(16);
    let buffer = factory.buffer(label, usage | BufferUsages::STORAGE, size);
    factory.queue.write_buffer(&buffer, 0, bytes);
    buffer
}

/// The most recently used geometries.
#[derive(Debug, Default)]
pub(crate) struct Geometries(Vec<GpuGeometry>);

impl Geometries {
    /// Two, for a scene and the same scene without casters, its negative control.
    const KEPT: usize = 2;

    /// Returns a geometry's buffers; uploads them unless they are cached.
    pub(crate) fn get(
        &mut self,
        factory: &mut ResourceFactory<'_>,
        geometry: &Geometry,
    ) -> Result<&GpuGeometry, BackendError> {
        let fingerprint = geometry.fingerprint();
        let known = self.0.iter().position(|g| g.fingerprint == fingerprint);
        match known {
            // Move the entry to the front.
            Some(i) => self.0[..=i].rotate_right(1),
            None => {
                self.0.truncate(Self::KEPT - 1);
                self.0.insert(0, GpuGeometry::upload(factory, geometry)?);
            }
        }
        Ok(&self.0[0])
    }
}
