//! Points that are lit or not.

use crate::{
    Facets, Points, Stated, Suns,
    rays::{NO_BLOCKER, Rays},
    stated::AnswerHash,
    suns::frame_towards,
};
use glam::DMat3;

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
    pub fn lit(&self, points: &Points, suns: &Suns, progress: impl FnMut(usize)) -> Lit {
        let rays = Rays::new(self, points);
        let frames: Vec<DMat3> = suns
            .directions()
            .iter()
            .map(|&sun| frame_towards(sun))
            .collect();
        let words = points.count().div_ceil(64);
        let mut lit = Lit {
            bits: vec![0; words * suns.directions().len()],
            points: points.count(),
            stated: Stated {
                margin_m: rays.margin,
                ..Stated::default()
            },
        };
        points.visit_rows(
            |neighbour: &mut Vec<u32>, row| flags_of(row, &rays, &frames, neighbour),
            |row, flags| {
                for (sun, flags) in flags.iter().enumerate() {
                    let word = &mut lit.bits[sun * words + row / 64];
                    *word |= u64::from(flags & 1) << (row % 64);
                    let is_undecided = flags & 2 != 0;
                    let pair = is_undecided.then_some((sun as u32, row as u32));
                    lit.stated.add_undecided(pair);
                }
            },
            progress,
        );
        lit.stated.keep_listed();
        let mut hash = AnswerHash::new();
        for &word in &lit.bits {
            hash.add_bits(word);
        }
        lit.stated.hash = hash.finish();
        lit
    }
}

/// Returns two bits for each sun: whether it lights a point, and whether that is undecided.
/// `neighbour` has the blockers of the point before, and gets those of this one.
fn flags_of(row: usize, rays: &Rays<'_>, frames: &[DMat3], neighbour: &mut Vec<u32>) -> Vec<u8> {
    neighbour.resize(frames.len(), NO_BLOCKER);
    // The blocker under the sun before probably shades the point still.
    let mut blocker = NO_BLOCKER;
    let flags = frames.iter().zip(neighbour).map(|(frame, neighbour)| {
        let guess = if blocker == NO_BLOCKER {
            *neighbour
        } else {
            blocker
        };
        let answer = rays.answer(row, frame, guess);
        blocker = answer.blocker;
        *neighbour = answer.blocker;
        u8::from(answer.is_lit) | u8::from(answer.is_undecided) << 1
    });
    flags.collect()
}
