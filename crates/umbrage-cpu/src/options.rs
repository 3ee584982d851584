//! Options of the CPU backend.

use crate::raster::{Clipping, PlaneShift, Rounding, VertexSums};
use rayon::{ThreadPool, ThreadPoolBuilder};
use umbrage_core::{BackendError, Invalid, Simd, Snapping, glam::Vec4};

/// Options of [`Cpu::with_options`](crate::Cpu::with_options). Threads and instructions do not
/// change results.
///
/// ```
/// # use umbrage_cpu::{Cpu, CpuOptions};
/// let cpu = Cpu::with_options(&CpuOptions::default().threads(2))?;
/// # Ok::<(), umbrage_core::BackendError>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CpuOptions {
    /// Number of threads of a separate pool, 1 to 1024. `None` uses rayon's global pool, with one
    /// thread per core.
    pub threads: Option<usize>,
    /// Instructions that loops are compiled for.
    pub simd: Simd,
    /// Rounding of vertices in the rasteriser. The default is that of Mesa's software drivers.
    /// Other values show the image on other devices.
    pub snapping: Snapping,
    /// Shift of the triangles' depths; none by default. Other values show which results depend on
    /// rounding.
    pub plane_shift: PlaneShift,
    /// Fractions by which the channels of filtered images change; 0 by default. Other values show
    /// which results depend on rounding.
    pub filter_shift: Vec4,
    /// Clipping of triangles: at the view volume, or as hardware may do it, to test techniques.
    pub clipping: Clipping,
    /// Order of sums in the transform of a vertex: that of the shader source, or another that
    /// devices may use.
    pub vertex_sums: VertexSums,
}

/// Greatest number of threads; larger values are rejected.
const MAX_THREADS: usize = 1024;

impl CpuOptions {
    /// Returns the options with a number of threads.
    #[must_use]
    pub fn threads(self, threads: usize) -> Self {
        Self {
            threads: Some(threads),
            ..self
        }
    }

    /// Returns the options with other instructions.
    #[must_use]
    pub fn simd(self, simd: Simd) -> Self {
        Self { simd, ..self }
    }

    /// Returns the options with another rounding of vertices.
    #[must_use]
    pub fn snapping(self, snapping: Snapping) -> Self {
        Self { snapping, ..self }
    }

    /// Returns the options with shifted depths of triangles.
    #[must_use]
    pub fn plane_shift(self, plane_shift: PlaneShift) -> Self {
        Self {
            plane_shift,
            ..self
        }
    }

    /// Returns the options with changed filtered images.
    #[must_use]
    pub fn filter_shift(self, filter_shift: Vec4) -> Self {
        Self {
            filter_shift,
            ..self
        }
    }

    /// Returns the options with another clipping.
    #[must_use]
    pub fn clipping(self, clipping: Clipping) -> Self {
        Self { clipping, ..self }
    }

    /// Returns the options with another order of sums in the transform of vertices.
    #[must_use]
    pub fn vertex_sums(self, vertex_sums: VertexSums) -> Self {
        Self {
            vertex_sums,
            ..self
        }
    }

    /// Returns the rounding of the rasteriser.
    pub(crate) fn rounding(&self) -> Rounding {
        Rounding {
            snapping: self.snapping,
            plane_shift: self.plane_shift,
            clipping: self.clipping,
            vertex_sums: self.vertex_sums,
        }
    }

    /// Returns a separate pool, if a number of threads is given.
    pub(crate) fn pool(&self) -> Result<Option<ThreadPool>, BackendError> {
        let Some(threads) = self.threads else {
            return Ok(None);
        };
        if threads == 0 || threads > MAX_THREADS {
            let help = format!("use 1 to {MAX_THREADS}, or omit it for one per core");
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
