//! Lookup times per block of pixels, for images of where a technique spends its time.

use crate::{Cpu, backend, receive::receive_span};
use umbrage_core::{BackendError, Inputs, Invalid, Receivers, Recipe, View, glam::UVec2};
use web_time::Instant;

impl Cpu {
    /// Returns the time of the lookup for each block of `block` pixels, in nanoseconds per pixel
    /// with a receiver: the least of `runs` runs, on one thread.
    ///
    /// Blocks are ordered row by row from the top left; those at the right and the lower edge may
    /// be smaller. The time is `None` for blocks without a receiver.
    ///
    /// Casts and filters run first and don't count. Each block is looked up separately, in rows of
    /// its own width, slightly slower than within a whole mask. The view must have receivers.
    ///
    /// # Errors
    /// Errors in the same cases as [`Backend::render`](umbrage_core::Backend::render), if the view
    /// has no receivers, or if `block` or `runs` is 0.
    pub fn lookup_times(
        &mut self,
        view: &View<'_>,
        recipe: &Recipe,
        block: UVec2,
        runs: u32,
    ) -> Result<Vec<Option<f32>>, BackendError> {
        let receivers = view.receivers.ok_or_else(backend::nothing_seen)?;
        if block.min_element() == 0 || runs == 0 {
            let why = format!("are {} x {} pixels, {runs} times", block.x, block.y);
            let help = "time blocks of at least one pixel at least once";
            return Err(Invalid::new("timed blocks", why, help).into());
        }
        let execute = |inputs: &Inputs<'_>| {
            let size = receivers.size;
            let mut times = Vec::new();
            for top in (0..size.y).step_by(block.y as usize) {
                for left in (0..size.x).step_by(block.x as usize) {
                    let corner = UVec2::new(left, top);
                    let part = block.min(size - corner);
                    times.push(block_time(inputs, recipe, receivers, corner, part, runs));
                }
            }
            times
        };
        self.install(|cpu| cpu.with_inputs(view, recipe, execute))
    }
}

/// Returns the time of one block, nanoseconds per receiver, or `None` without a receiver.
fn block_time(
    inputs: &Inputs<'_>,
    recipe: &Recipe,
    receivers: &Receivers,
    corner: UVec2,
    part: UVec2,
    runs: u32,
) -> Option<f32> {
    let width = receivers.size.x;
    let row_at = |row: u32| ((corner.y + row) * width + corner.x) as usize;
    let receiving: usize = (0..part.y)
        .map(|row| {
            let receives = &receivers.receives[row_at(row)..][..part.x as usize];
            receives.iter().filter(|&&receives| receives).count()
        })
        .sum();
    if receiving == 0 {
        return None;
    }
    let mut out = vec![1.0; part.x as usize];
    let mut least = f32::INFINITY;
    for _ in 0..runs {
        let begin = Instant::now();
        for row in 0..part.y {
            receive_span(inputs, recipe, receivers, row_at(row), &mut out);
        }
        least = least.min(begin.elapsed().as_secs_f32());
    }
    Some(1e9 * least / receiving as f32)
}
