//! Rays that are not known to be blocked: a bit for each ray of a block, each block of a group, and
//! so on up to the top.

use super::boxes::BOXES;
use std::sync::atomic::{AtomicU8, Ordering};
use umbrage_core::parallel::prelude::*;

/// Bits that are only ever cleared.
#[derive(Debug)]
pub(super) struct Open {
    /// Bits of the rays of each block.
    rays: Vec<AtomicU8>,
    /// Bits of the blocks in groups of eight, then of each eight groups, and so on up to one word.
    groups: Vec<Vec<AtomicU8>>,
}

/// Returns words with this number of set bits in total, eight per word.
fn words(bits: usize) -> Vec<AtomicU8> {
    let in_word = |first: usize| (bits - first).min(BOXES);
    let word = |first| AtomicU8::new(u8::MAX >> (BOXES - in_word(first)));
    (0..bits).step_by(BOXES).map(word).collect()
}

impl Open {
    /// Returns bits in which all rays of `blocks` are open. The last block has `in_last` rays, the
    /// others eight.
    pub(super) fn all(blocks: usize, in_last: usize) -> Self {
        let rays = words((blocks - 1) * BOXES + in_last);
        let mut groups = vec![words(blocks)];
        while let Some(below) = groups.last().map(Vec::len)
            && below > 1
        {
            groups.push(words(below));
        }
        Self { rays, groups }
    }

    /// Returns a bit for each ray of a block that is not known to be blocked.
    #[inline(always)]
    pub(super) fn rays(&self, block: usize) -> u32 {
        // Other threads' updates may be late. A blocked ray is then tested again.
        self.rays[block].load(Ordering::Relaxed).into()
    }

    /// Returns a bit for each part of a group that has open rays. Parts of groups of level 0 are
    /// blocks.
    #[inline(always)]
    pub(super) fn parts(&self, level: usize, group: usize) -> u32 {
        self.groups[level][group].load(Ordering::Relaxed).into()
    }

    /// Marks rays of a block as blocked.
    #[inline(always)]
    pub(super) fn close_rays(&self, block: usize, rays: u32) {
        let blocked = rays as u8;
        let before = self.rays[block].fetch_and(!blocked, Ordering::Relaxed);
        if before & !blocked == 0 {
            self.close_parts(0, block / BOXES, 1 << (block % BOXES));
        }
    }

    /// Marks all rays of some parts of a group as blocked.
    #[inline(always)]
    pub(super) fn close_parts(&self, level: usize, group: usize, parts: u32) {
        let mut level = level;
        let mut group = group;
        let mut closed = parts as u8;
        loop {
            let before = self.groups[level][group].fetch_and(!closed, Ordering::Relaxed);
            if before & !closed != 0 || level + 1 == self.groups.len() {
                return;
            }
            closed = 1 << (group % BOXES);
            group /= BOXES;
            level += 1;
        }
    }

    /// Calls `tell` with each block that has open rays, and a bit for each of these. A thread
    /// processes at least `at_least` of the lowest groups.
    pub(super) fn for_each(&self, at_least: usize, tell: impl Fn(usize, u32) + Sync) {
        let tell_group = |group: usize| {
            if !self.is_open(group) {
                return;
            }
            let mut parts = self.parts(0, group);
            while let Some(part) = take_lowest(&mut parts) {
                let block = group * BOXES + part;
                tell(block, self.rays(block));
            }
        };
        let groups = (0..self.groups[0].len()).into_par_iter();
        groups.with_min_len(at_least).for_each(tell_group);
    }

    /// Returns whether a lowest group and all its parents have open rays.
    fn is_open(&self, group: usize) -> bool {
        let mut part = group;
        (1..self.groups.len()).all(|level| {
            let bit = 1 << (part % BOXES);
            part /= BOXES;
            self.parts(level, part) & bit != 0
        })
    }
}

/// Clears the lowest bit, and returns its position.
#[inline(always)]
pub(super) fn take_lowest(bits: &mut u32) -> Option<usize> {
    let place = bits.trailing_zeros();
    *bits &= bits.wrapping_sub(1);
    (place < u32::BITS).then_some(place as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    fn open_rays(open: &Open) -> Vec<usize> {
        let found = Mutex::new(Vec::new());
        open.for_each(1, |block, mut rays| {
            while let Some(ray) = take_lowest(&mut rays) {
                found.lock().unwrap().push(block * BOXES + ray);
            }
        });
        let mut out = found.into_inner().unwrap();
        out.sort_unstable();
        out
    }

    #[test]
    fn what_is_closed_is_closed_above_and_below() {
        // 70 blocks are nine groups, and two groups of groups.
        let open = Open::all(70, 3);
        assert_eq!(open_rays(&open), (0..69 * 8 + 3).collect::<Vec<_>>());
        open.close_rays(1, 0b1010_0001);
        assert_eq!(open.rays(1), 0b0101_1110);
        assert_eq!(open.parts(0, 0), 0xff);
        open.close_rays(1, 0xff);
        assert_eq!(open.parts(0, 0), 0b1111_1101);
        // Close all blocks of the last group but one, then that one.
        for block in 64..69 {
            open.close_rays(block, 0xff);
        }
        assert_eq!(open.parts(1, 1), 1);
        open.close_rays(69, 0b111);
        assert_eq!(open.parts(1, 1), 0);
        assert_eq!(open.parts(2, 0), 0b01);
        // Close a whole group.
        open.close_parts(1, 0, 0b0000_0001);
        assert_eq!(open_rays(&open), (64..64 * 8).collect::<Vec<_>>());
        open.close_parts(1, 0, 0xff);
        assert_eq!(open.parts(2, 0), 0);
        assert!(open_rays(&open).is_empty());
    }
}
