//! A yardstick: a fixed workload, timed in turn with every row. Rows of different runs are compared
//! as multiples of it.
//!
//! Temporary slowdowns of a machine (other programs, heat, a governor) affect the yardstick, too,
//! and cancel out of the ratio: duet benchmarking (Bulej, Horký, Tůma, Farquet and Prokopec 2020,
//! "Duet Benchmarking: Improving Measurement Accuracy in the Cloud").
//!
//! The work is a chain of table loads and integer products, executed as a recipe. So it runs where
//! the row runs, on the same threads or the same adapter, and is timed by the same clock. It uses
//! no technique, rasteriser or map; it shares only the loop over receivers with the row.

use std::sync::{Arc, OnceLock};
use umbrage_core::{
    Inputs, Kernel, Module, Receive, ReceiveKernel, Receivers, Recipe, Span, Table, UniformBlock,
    light_sample::hash, module, uniforms,
};

/// Number of links of the chain in a unit of work, over all receivers: one or two milliseconds on
/// two threads.
const LINKS: u64 = 1 << 19;

/// Number of rows of the table: 1 MiB, more than the caches next to a core and less than a map of
/// middle size.
const ROWS: u32 = 1 << 16;

/// The yardstick for a row.
///
/// It keeps the row's images and tables, so that nothing is freed and rebuilt between the two. It
/// takes about a quarter of the row's time by its counted cost, which is equal on every run.
///
/// A yardstick of a very different length meets other noise. Work that fits between two turns of
/// the system's scheduler is never interrupted; work ten times as long always is. A yardstick as
/// long as the row would double the time of a comparison.
#[derive(Clone, Debug)]
pub struct Yardstick {
    /// Recipe that runs the chain.
    pub recipe: Recipe,
    /// Units of work in the recipe.
    pub units: f64,
}

/// Approximate counted cost of a unit, milliseconds.
const UNIT_MS: f64 = 1.0;
/// Ratio of a yardstick's length to its row's.
const SHARE: f64 = 0.25;
/// Units of the shortest yardstick, which still takes far longer than a clock's step.
pub const MIN_UNITS: f64 = 1.0 / 32.0;
/// Units of the longest yardstick.
pub const MAX_UNITS: f64 = 256.0;

impl Yardstick {
    /// Returns the yardstick for a row of this counted cost. `None` if nothing receives, as there
    /// is no work then.
    pub fn new(row: &Recipe, receivers: &Receivers, cost_ms: f64) -> Option<Self> {
        Self::with_units(row, receivers, SHARE * cost_ms / UNIT_MS)
    }

    /// Returns a yardstick of about this many units, at most [`MAX_UNITS`]. `None` if nothing
    /// receives.
    pub fn with_units(row: &Recipe, receivers: &Receivers, units: f64) -> Option<Self> {
        let count = receivers.receives.iter().filter(|&&r| r).count() as u64;
        if count == 0 {
            return None;
        }
        let wanted = units.clamp(MIN_UNITS, MAX_UNITS);
        let links = ((wanted * LINKS as f64 / count as f64).round() as u32).max(1);
        let mut tables = row.tables.clone();
        tables.push(Table {
            label: "yardstick",
            rows: table().into(),
        });
        let kernel = Arc::new(YardstickKernel {
            uniforms: YardstickUniforms {
                mask: ROWS - 1,
                links,
            },
            rows: table(),
        });
        let receive = Receive {
            kernel,
            inputs: Vec::new(),
            tables: vec![row.tables.len()],
        };
        let recipe = Recipe {
            images: row.images.clone(),
            tables,
            casts: Vec::new(),
            filters: Vec::new(),
            receive,
            shade: None,
            hierarchy: None,
            keep_images: false,
        };
        Some(Self {
            recipe,
            units: f64::from(links) * count as f64 / LINKS as f64,
        })
    }
}

/// Returns the table of pseudorandom words, which is built once.
fn table() -> Arc<[[u32; 4]]> {
    static TABLE: OnceLock<Arc<[[u32; 4]]>> = OnceLock::new();
    TABLE
        .get_or_init(|| (0..ROWS).map(|i| [hash(i), 0, 0, 0]).collect())
        .clone()
}

uniforms! {
    /// Uniforms of [`YardstickKernel`].
    pub struct YardstickUniforms {
        /// Number of rows of the table minus one; the number is a power of two. It is the first
        /// field: see `STEADY_FIRST_WORD` in umbrage-wgpu's drivers.rs.
        pub mask: u32,
        /// Number of links of each receiver's chain.
        pub links: u32,
    }
}

/// A chain of loads and products.
#[derive(Clone, Debug)]
pub struct YardstickKernel {
    /// Uniforms.
    pub uniforms: YardstickUniforms,
    rows: Arc<[[u32; 4]]>,
}

impl Kernel for YardstickKernel {
    fn modules(&self) -> Vec<Module> {
        vec![module!("yardstick")]
    }

    fn uniforms(&self) -> Option<&dyn UniformBlock> {
        Some(&self.uniforms)
    }
}

impl ReceiveKernel for YardstickKernel {
    fn receive(&self, _: &Inputs<'_>, span: &Span<'_>, out: &mut [f32]) {
        for (i, out) in out.iter_mut().enumerate() {
            *out = self.chain(span.first.x + i as u32, span.first.y);
        }
    }
}

impl YardstickKernel {
    /// Runs the chain. The result is unused, but depends on every link, so that compilers can't
    /// omit any.
    fn chain(&self, x: u32, y: u32) -> f32 {
        let mut state = x
            .wrapping_mul(0x9e37_79b9)
            .wrapping_add(y.wrapping_mul(0x85eb_ca6b));
        for _ in 0..self.uniforms.links {
            let row = self.rows[((state >> 7) & self.uniforms.mask) as usize];
            state = (state ^ row[0]).wrapping_mul(0x2c1b_3c6d);
            state ^= state >> 15;
        }
        (state >> 24) as f32 / 255.0
    }
}
