//! Points that are lit or not.

use crate::{
    Facets, Points, Stated, Suns,
    frame::Frame,
    rays::{NO_BLOCKER, Rays},
    stated::AnswerHash,
};
use rayon::prelude::*;

/// Points per task.
const TASK: usize = 256;
/// Pairs of a sun and a point that are computed at once: a byte each.
const MOST_PAIRS: usize = 1 << 26;

/// Which points are lit, one bit for each sun and point.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lit {
    /// Bits of a sun's points, least bit first; a whole number of words per sun.
    bits: Vec<u64>,
    points: usize,
    /// Accuracy and hash.
    pub stated: Stated,
}

impl Lit {
    /// Returns whether a point is lit.
    ///
    /// # Panics
    /// Panics if there is no such sun or point.
    pub fn is_lit(&self, sun: usize, row: usize) -> bool {
        assert!(row < self.points, "point {row} of {}", self.points);
        let word = self.words(sun)[row / 64];
        word >> (row % 64) & 1 == 1
    }

    /// Returns the bits of a sun's points: bit `row % 64` of word `row / 64`.
    ///
    /// # Panics
    /// Panics if there is no such sun.
    pub fn words(&self, sun: usize) -> &[u64] {
        let count = self.points.div_ceil(64);
        &self.bits[sun * count..(sun + 1) * count]
    }
}

impl Facets {
    /// Returns which points see the centre of each sun. `progress` receives the number of computed
    /// points from time to time.
    ///
    /// Facets within the margin of a point don't shade it, so points may be on facets. Undecided
    /// are points whose ray to the sun passes an edge within the margin, unless another facet
    /// shades them.
    pub fn lit(&self, points: &Points, suns: &Suns, mut progress: impl FnMut(usize)) -> Lit {
        let rays = Rays::new(self, points);
        let frames: Vec<Frame> = suns
            .directions()
            .iter()
            .map(|&sun| Frame::new(sun))
            .collect();
        let words = points.len().div_ceil(64);
        let mut lit = Lit {
            bits: vec![0; words * suns.len()],
            points: points.len(),
            stated: Stated {
                margin_m: rays.margin(),
                ..Stated::default()
            },
        };
        let block = (MOST_PAIRS / suns.len().max(1)).clamp(16 * TASK, 256 * TASK);
        let mut computed = 0;
        for block in points.order.chunks(block) {
            let tasks = block.par_chunks(TASK);
            let flags: Vec<Vec<u8>> = tasks.map(|rows| flags_of(rows, &rays, &frames)).collect();
            for (rows, flags) in block.chunks(TASK).zip(&flags) {
                for (sun, flags) in flags.chunks(rows.len()).enumerate() {
                    for (&row, flag) in rows.iter().zip(flags) {
                        let word = &mut lit.bits[sun * words + row as usize / 64];
                        *word |= u64::from(flag & 1) << (row % 64);
                        let is_undecided = flag & 2 != 0;
                        let pair = is_undecided.then_some((sun as u32, row));
                        lit.stated.add_undecided(pair);
                    }
                }
            }
            computed += block.len();
            progress(computed);
        }
        lit.stated.keep_listed();
        let mut hash = AnswerHash::new();
        for &word in &lit.bits {
            hash.add_bits(word);
        }
        lit.stated.hash = hash.finish();
        lit
    }
}

/// Returns two bits for each sun and point: whether it is lit, and whether that is undecided.
fn flags_of(rows: &[u32], rays: &Rays<'_>, frames: &[Frame]) -> Vec<u8> {
    let mut out = Vec::with_capacity(rows.len() * frames.len());
    // The blocker of each point under the sun before, which probably shades it still.
    let mut blockers = vec![NO_BLOCKER; rows.len()];
    for frame in frames {
        let mut neighbours = NO_BLOCKER;
        for (&row, blocker) in rows.iter().zip(&mut blockers) {
            let guess = if *blocker == NO_BLOCKER {
                neighbours
            } else {
                *blocker
            };
            let answer = rays.answer(row as usize, frame, guess);
            out.push(u8::from(answer.is_lit) | u8::from(answer.is_undecided) << 1);
            *blocker = answer.blocker;
            neighbours = answer.blocker;
        }
    }
    out
}
