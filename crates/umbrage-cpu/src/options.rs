//! What a user may choose about the CPU player.

use crate::raster::{Clipping, PlaneShift, Rounding, VertexSums};
use rayon::{ThreadPool, ThreadPoolBuilder};
use umbrage_core::{BackendError, Invalid, Simd, Snapping, glam::Vec4};

/// Options of [`Cpu::with_options`](crate::Cpu::with_options). Threads and instructions change no
/// result.
///
/// ```
/// # use umbrage_cpu::{Cpu, CpuOptions};
/// let cpu = Cpu::with_options(&CpuOptions::default().threads(2))?;
/// # Ok::<(), umbrage_core::BackendError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CpuOptions {
    /// Threads of a pool of its own, 1 to 1024; none: rayon's global pool, which has one a core.
    pub threads: Option<usize>,
    /// The instructions that loops are compiled for.
    pub simd: Simd,
    /// How the rasteriser rounds vertices: another device's way instead of that of Mesa's software
    /// drivers, to find out what becomes of a picture there.
    pub snapping: Snapping,
    /// How far depths of triangles are moved: nowhere, but to find out which answers hang on
    /// rounding.
    pub plane_shift: PlaneShift,
    /// Fractions by which the channels of filtered images change. Other values than 0 show which
    /// answers depend on rounding.
    pub filter_shift: Vec4,
    /// Where the rasteriser clips triangles: at the view volume, or as hardware may do, to test
    /// techniques.
    pub clipping: Clipping,
    /// Order of sums in the transform of a vertex: the written one, or another that devices may
    /// use.
    pub vertex_sums: VertexSums,
}

/// More threads than this are taken for a mistake.
const MAX_THREADS: usize = 1024;

impl CpuOptions {
    /// The same with a number of threads.
    #[must_use]
    pub fn threads(self, threads: usize) -> Self {
        Self {
            threads: Some(threads),
            ..self
        }
    }

    /// The same with other instructions.
    #[must_use]
    pub fn simd(self, simd: Simd) -> Self {
        Self { simd, ..self }
    }

    /// The same with another rounding of vertices.
    #[must_use]
    pub fn snapping(self, snapping: Snapping) -> Self {
        Self { snapping, ..self }
    }

    /// The same with depths of triangles moved.
    #[must_use]
    pub fn plane_shift(self, plane_shift: PlaneShift) -> Self {
        Self {
            plane_shift,
            ..self
        }
    }

    /// The same with filtered images changed.
    #[must_use]
    pub fn filter_shift(self, filter_shift: Vec4) -> Self {
        Self {
            filter_shift,
            ..self
        }
    }

    /// The same with another way of clipping.
    #[must_use]
    pub fn clipping(self, clipping: Clipping) -> Self {
        Self { clipping, ..self }
    }

    /// The same with vertices transformed in another order.
    #[must_use]
    pub fn vertex_sums(self, vertex_sums: VertexSums) -> Self {
        Self {
            vertex_sums,
            ..self
        }
    }

    /// How the rasteriser is to round.
    pub(crate) fn rounding(&self) -> Rounding {
        Rounding {
            snapping: self.snapping,
            plane_shift: self.plane_shift,
            clipping: self.clipping,
            vertex_sums: self.vertex_sums,
        }
    }

    /// Its own pool, if it asks for one.
    pub(crate) fn pool(&self) -> Result<Option<ThreadPool>, BackendError> {
        let Some(threads) = self.threads else {
            return Ok(None);
        };
        if threads == 0 || threads > MAX_THREADS {
            let help = format!("use 1 to {MAX_THREADS}, or none for one a core");
            return Err(Invalid::new("number of threads", format!("is {threads}"), help).into());
        }
        let pool = ThreadPoolBuilder::new()
            .num_threads(threads)
            .thread_name(|i| format!("umbrage-cpu-{i}"))
            .build();
        pool.map(Some).map_err(|e| {
            BackendError::OutOfMemory(format!("{threads} threads could not be started ({e})"))
        })
    }
}
