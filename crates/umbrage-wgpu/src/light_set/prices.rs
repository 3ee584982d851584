//! Costs of drawing a triangle and of copying a texel on this device, measured with timestamps if
//! available.
//!
//! Results arrive a few frames later, without waiting. They only decide between drawing and
//! copying, which are bit-equal.

use crate::resources::{late_read::LateRead, query_pairs::QueryPairs};
use wgpu::{CommandEncoder, Device, Features, Queue, RenderPassTimestampWrites};

/// Texels copied in the time of drawing a triangle, on devices without timestamps. An estimate: a
/// copy reads and writes four bytes per texel, and a small triangle needs a few hundred bytes of
/// vertices, set-up and texels.
const TEXELS_A_TRIANGLE: f64 = 24.0;
/// Weight of a new measurement in the running mean.
const NEW_SHARE: f64 = 0.25;
/// Number of initial frames with redraws that are all measured; after them one of [`RARE`] is.
const FIRST_FRAMES: u32 = 16;
/// See [`FIRST_FRAMES`].
const RARE: u32 = 32;

/// Measured costs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Prices {
    /// Seconds to draw a triangle.
    pub(crate) triangle: Option<f64>,
    /// Seconds to copy a texel.
    pub(crate) texel: Option<f64>,
}

impl Prices {
    /// Returns the number of texels copied in the time of drawing a triangle.
    pub(crate) fn texels_a_triangle(&self) -> f64 {
        match (self.triangle, self.texel) {
            (Some(triangle), Some(texel)) if texel > 0.0 => triangle / texel,
            _ => TEXELS_A_TRIANGLE,
        }
    }

    /// Adds a measurement to the means.
    fn add(&mut self, measured: Self) {
        let mean = |held: &mut Option<f64>, new: Option<f64>| {
            if let Some(new) = new {
                let before = held.unwrap_or(new);
                *held = Some(before + NEW_SHARE * (new - before));
            }
        };
        mean(&mut self.triangle, measured.triangle);
        mean(&mut self.texel, measured.texel);
    }
}

/// Amounts of work timed in a frame.
#[derive(Clone, Copy, Debug, Default)]
struct Timed {
    triangles: Option<u64>,
    texels: Option<u64>,
}

/// Measures costs.
#[derive(Debug)]
pub(crate) struct PriceMeter {
    prices: Prices,
    queries: Option<Queries>,
    /// Number of frames with redraws so far.
    frames: u32,
    /// The work timed by the queries in flight.
    timed: Timed,
}

#[derive(Debug)]
struct Queries {
    pairs: QueryPairs,
    read: LateRead,
    /// Seconds per tick; `None` before there is a queue.
    period: Option<f64>,
}

/// Index of the draw's query pair.
const DRAW: u32 = 0;
/// Index of the copy's query pair.
const COPY: u32 = 1;

impl PriceMeter {
    /// Returns a meter; it measures nothing if the device lacks timestamps in passes or encoders.
    pub(crate) fn new(device: &Device) -> Self {
        let needed = Features::TIMESTAMP_QUERY | Features::TIMESTAMP_QUERY_INSIDE_ENCODERS;
        let has_timestamps = device.features().contains(needed);
        Self {
            prices: Prices::default(),
            queries: has_timestamps.then(|| Queries::new(device)),
            frames: 0,
            timed: Timed::default(),
        }
    }

    pub(crate) fn prices(&self) -> &Prices {
        &self.prices
    }

    /// Sets the costs, and disables measurement.
    #[cfg(feature = "testing")]
    pub(crate) fn assume(&mut self, prices: Prices) {
        self.prices = prices;
        self.queries = None;
    }

    /// Reads the measurement of an earlier frame, if it has arrived.
    pub(crate) fn collect(&mut self, queue: &Queue) {
        let Some(queries) = &mut self.queries else {
            return;
        };
        let period = *queries
            .period
            .get_or_insert_with(|| 1e-9 * f64::from(queue.get_timestamp_period()));
        let elapsed =
            |bytes: &[u8]| [DRAW, COPY].map(|pair| QueryPairs::elapsed_ticks(bytes, pair));
        let Some(ticks) = queries.read.take(elapsed) else {
            return;
        };
        let [draw, copy] = ticks.map(|ticks| Some(ticks? as f64 * period));
        let each = |seconds: Option<f64>, count: Option<u64>| Some(seconds? / count? as f64);
        self.prices.add(Prices {
            triangle: each(draw, self.timed.triangles),
            texel: each(copy, self.timed.texels),
        });
    }

    /// Returns the meter for this frame's passes, if it is to be measured.
    pub(crate) fn begin_frame(&mut self) -> Option<FrameMeter<'_>> {
        let queries = self.queries.as_ref()?;
        if !queries.read.is_idle() {
            return None;
        }
        self.frames = self.frames.saturating_add(1);
        let is_measured = self.frames <= FIRST_FRAMES || self.frames.is_multiple_of(RARE);
        is_measured.then(|| {
            self.timed = Timed::default();
            FrameMeter {
                queries,
                timed: &mut self.timed,
            }
        })
    }
}

/// Times one draw and one copy of a frame.
#[derive(Debug)]
pub(crate) struct FrameMeter<'a> {
    queries: &'a Queries,
    timed: &'a mut Timed,
}

impl FrameMeter<'_> {
    /// Returns the timestamps of a pass that draws this number of triangles into a cleared layer,
    /// if it is to be timed.
    pub(crate) fn draw(&mut self, triangles: u64) -> Option<RenderPassTimestampWrites<'_>> {
        if self.timed.triangles.is_some() || triangles == 0 {
            return None;
        }
        self.timed.triangles = Some(triangles);
        Some(RenderPassTimestampWrites {
            query_set: &self.queries.pairs.set,
            beginning_of_pass_write_index: Some(2 * DRAW),
            end_of_pass_write_index: Some(2 * DRAW + 1),
        })
    }

    /// Records a copy of this number of texels, between timestamps if it is to be timed.
    pub(crate) fn copy(
        &mut self,
        encoder: &mut CommandEncoder,
        texels: u64,
        record: impl FnOnce(&mut CommandEncoder),
    ) {
        if self.timed.texels.is_some() {
            record(encoder);
            return;
        }
        self.timed.texels = Some(texels);
        encoder.write_timestamp(&self.queries.pairs.set, 2 * COPY);
        record(encoder);
        encoder.write_timestamp(&self.queries.pairs.set, 2 * COPY + 1);
    }

    /// Records the readback of the timestamps.
    pub(crate) fn end(self, encoder: &mut CommandEncoder) {
        let Queries { pairs, read, .. } = self.queries;
        let is_timed = [self.timed.triangles.is_some(), self.timed.texels.is_some()];
        for (pair, is_timed) in [DRAW, COPY].into_iter().zip(is_timed) {
            if is_timed {
                pairs.resolve(encoder, pair);
            }
        }
        if is_timed.contains(&true) {
            read.record(encoder, &pairs.resolved);
        }
    }
}

impl Queries {
    fn new(device: &Device) -> Self {
        const LABEL: &str = "umbrage prices";
        let pairs = QueryPairs::new(device, LABEL, 2);
        Self {
            read: LateRead::new(device, LABEL, pairs.resolved.size()),
            pairs,
            period: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn measured_prices_replace_the_estimate() {
        let mut prices = Prices::default();
        assert_eq!(prices.texels_a_triangle(), TEXELS_A_TRIANGLE);
        prices.add(Prices {
            triangle: Some(3e-6),
            texel: None,
        });
        assert_eq!(prices.texels_a_triangle(), TEXELS_A_TRIANGLE, "half of it");
        for texel in [1e-6, 2e-6, 2e-6, 2e-6, 2e-6, 2e-6, 2e-6, 2e-6, 2e-6] {
            prices.add(Prices {
                triangle: None,
                texel: Some(texel),
            });
        }
        let ratio = prices.texels_a_triangle();
        assert!((1.5..1.7).contains(&ratio), "{ratio} after nine copies");
    }
}
