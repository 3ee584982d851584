//! What a candidate returns for a frame, and the counts that follow from it.

use crate::frame::Frame;
use std::time::Duration;

/// Side of a block of 32 receivers, pixels.
const BLOCK: [u32; 2] = [8, 4];
/// Bytes that each receiver reads and writes: position, normal, id, answer.
const RECEIVER_BYTES: f64 = 36.0;

/// Result of a candidate.
pub(crate) struct Outcome {
    pub(crate) candidate: String,
    /// Bits of each pixel's visibility.
    pub(crate) answers: Vec<u32>,
    /// Numbers of nodes or items walked, and of triangle tests, of each pixel.
    pub(crate) counted: Vec<[u32; 2]>,
    pub(crate) make: Duration,
    pub(crate) look_up: Duration,
    pub(crate) made: Made,
    /// Bytes read per node or item walked, and per test.
    pub(crate) bytes_walked: f64,
    pub(crate) bytes_tested: f64,
    /// Further bytes per receiver: what all receivers together do before they are answered.
    pub(crate) bytes_more: f64,
    /// If lanes are casters: the longest walk of one, and the sum over blocks of 32 casters of the
    /// longest walk, per block of receivers.
    pub(crate) caster_walks: Option<[f64; 2]>,
}

/// What making a structure costs, per caster.
#[derive(Clone, Copy, Default)]
pub(crate) struct Made {
    /// References, items or nodes.
    pub(crate) items: f64,
    /// Bytes read and written by all passes.
    pub(crate) bytes: f64,
    /// Atomics in storage buffers.
    pub(crate) atomics: f64,
    /// Bytes that the lookup reads from.
    pub(crate) kept: f64,
    /// Bytes that only making uses.
    pub(crate) scratch: f64,
}

/// Counts of a lookup.
pub(crate) struct Counts {
    pub(crate) differing: usize,
    pub(crate) tests: f64,
    pub(crate) walked: f64,
    pub(crate) longest_walk: f64,
    pub(crate) most_tests: u32,
    /// Greatest mean number of tests of a block of 32 receivers.
    pub(crate) worst_block: f64,
    /// Mean over blocks of the most tests, and of the longest walk, of a receiver.
    pub(crate) lockstep_tests: f64,
    pub(crate) lockstep_walk: f64,
    pub(crate) bytes: f64,
}

impl Outcome {
    /// Returns the counts over receivers that face the light.
    pub(crate) fn counts(&self, frame: &Frame) -> Counts {
        let pairs = self.answers.iter().zip(&frame.expected);
        let differing = pairs.filter(|(a, b)| a != b).count();
        let asking = frame.faces_light.iter().filter(|&&f| f).count().max(1) as f64;
        let total = |part: usize| {
            let all = self.counted.iter().map(|c| f64::from(c[part]));
            all.sum::<f64>()
        };
        let most = |part: usize| self.counted.iter().map(|c| c[part]).max().unwrap_or(0);
        let (tests, walked) = (total(1) / asking, total(0) / asking);

        let across = frame.size.x.div_ceil(BLOCK[0]);
        let blocks = (across * frame.size.y.div_ceil(BLOCK[1])) as usize;
        let mut sums = vec![[0_u32; 2]; blocks];
        let mut longest = vec![[0_u32; 2]; blocks];
        for (i, counted) in self.counted.iter().enumerate() {
            let [x, y] = [i as u32 % frame.size.x, i as u32 / frame.size.x];
            let block = (y / BLOCK[1] * across + x / BLOCK[0]) as usize;
            sums[block][0] += u32::from(frame.faces_light[i]);
            sums[block][1] += counted[1];
            for part in 0..2 {
                longest[block][part] = longest[block][part].max(counted[part]);
            }
        }
        let in_block = sums
            .iter()
            .map(|s| f64::from(s[1]) / f64::from(s[0].max(1)));
        // Blocks without a receiver that faces the light are not walked.
        let walking = sums.iter().filter(|s| s[0] > 0).count().max(1) as f64;
        let lockstep = |part: usize| {
            let all = longest.iter().map(|l| f64::from(l[part]));
            all.sum::<f64>() / walking
        };
        let receiver_walks = [f64::from(most(0)), lockstep(0)];
        let [longest_walk, lockstep_walk] = self.caster_walks.unwrap_or(receiver_walks);
        Counts {
            differing,
            tests,
            walked,
            longest_walk,
            most_tests: most(1),
            worst_block: in_block.fold(0.0, f64::max),
            lockstep_tests: lockstep(1),
            lockstep_walk,
            bytes: RECEIVER_BYTES
                + self.bytes_more
                + walked * self.bytes_walked
                + tests * self.bytes_tested,
        }
    }
}
