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

    /// Returns the number of lit points under a sun.
    ///
    /// # Panics
    /// Panics if there is no such sun.
    pub fn count(&self, sun: usize) -> usize {
        self.words(sun)
            .iter()
            .map(|word| word.count_ones() as usize)
            .sum()
    }
}

impl Facets {
    /// Returns which points see the centre of each sun.
    ///
    /// Facets within the margin of a point don't shade it, so points may be on facets. Undecided
    /// are points whose ray to the sun passes an edge within the margin, unless another facet
    /// shades them.
    pub fn lit(&self, points: &Points, suns: &Suns) -> Lit {
        let rays = Rays::new(self, points);
        let frames: Vec<Frame> = suns
            .directions()
            .iter()
            .map(|&sun| Frame::new(sun))
            .collect();
        // Per task: two bits for each sun and point, whether it is lit and whether undecided.
        let tasks: Vec<Vec<u8>> = points
            .order
            .par_chunks(TASK)
            .map(|rows| {
                let mut out = Vec::with_capacity(rows.len() * frames.len());
                // The blocker of each point under the sun before, which probably shades it still.
                let mut blockers = vec![NO_BLOCKER; rows.len()];
                for frame in &frames {
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
            })
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
        for sun in 0..suns.len() {
            let mut undecided = Vec::new();
            for (rows, flags) in points.order.chunks(TASK).zip(&tasks) {
                let flags = &flags[sun * rows.len()..(sun + 1) * rows.len()];
                for (&row, flag) in rows.iter().zip(flags) {
                    lit.bits[sun * words + row as usize / 64] |= u64::from(flag & 1) << (row % 64);
                    if flag & 2 != 0 {
                        undecided.push(row);
                    }
                }
            }
            undecided.sort_unstable();
            lit.stated.add_undecided(sun, undecided);
        }
        let mut hash = AnswerHash::new();
        for &word in &lit.bits {
            hash.add_bits(word);
        }
        lit.stated.hash = hash.finish();
        lit
    }
}
