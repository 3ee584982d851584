//! Sorts rays by position, with two passes of a radix sort from the lowest digit up (Knuth 1998,
//! "The Art of Computer Programming" 3, section 5.2.5). Passes keep the order of equal keys. A
//! comparison sort takes three times as long.

use std::sync::atomic::{AtomicU64, Ordering};
use umbrage_core::parallel::prelude::*;

/// Number of bits of a key.
pub(super) const KEY_BITS: u32 = 2 * DIGIT_BITS;
/// Number of bits that are sorted at a time.
const DIGIT_BITS: u32 = 12;
const DIGITS: usize = 1 << DIGIT_BITS;
/// Bit offset of the key in an entry.
const KEY_SHIFT: u32 = 32;

/// Key and pixel of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Entry(u64);

impl Entry {
    /// Returns the entry of a key below 2^[`KEY_BITS`].
    #[inline(always)]
    pub(super) fn new(key: u32, pixel: u32) -> Self {
        Self(u64::from(key) << KEY_SHIFT | u64::from(pixel))
    }

    #[inline(always)]
    pub(super) fn key(self) -> u32 {
        (self.0 >> KEY_SHIFT) as u32
    }

    #[inline(always)]
    pub(super) fn pixel(self) -> u32 {
        self.0 as u32
    }

    #[inline(always)]
    fn digit(self, pass: u32) -> usize {
        self.key() as usize >> (pass * DIGIT_BITS) & (DIGITS - 1)
    }
}

/// Entries that several threads write, each at its own positions.
pub(super) struct Sorted(Vec<AtomicU64>);

impl Sorted {
    fn room_for(count: usize) -> Self {
        Self((0..count).map(|_| AtomicU64::new(0)).collect())
    }

    /// Returns the number of entries.
    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    /// Returns entry `i`.
    #[inline(always)]
    pub(super) fn get(&self, i: usize) -> Entry {
        Entry(self.0[i].load(Ordering::Relaxed))
    }

    /// Returns the number of entries with keys below this one.
    pub(super) fn entries_below(&self, key: u32) -> usize {
        let is_below = |entry: &AtomicU64| Entry(entry.load(Ordering::Relaxed)).key() < key;
        self.0.partition_point(is_below)
    }
}

/// Returns the entries of all parts, sorted by key. Entries with equal keys keep their order.
pub(super) fn sort(parts: &[Vec<Entry>]) -> Sorted {
    let by_low_digit = pass(parts, 0, |part, i| part[i], Vec::len);
    let count = by_low_digit.len();
    let a_part = count.div_ceil(parts.len().max(1)).max(1);
    let ranges: Vec<_> = (0..count)
        .step_by(a_part)
        .map(|first| first..count.min(first + a_part))
        .collect();
    let read = |range: &std::ops::Range<usize>, i: usize| by_low_digit.get(range.start + i);
    pass(&ranges, 1, read, ExactSizeIterator::len)
}

/// Sorts the entries of all parts by one digit. `read` returns an entry of a part, `len` their
/// number.
fn pass<P: Sync>(
    parts: &[P],
    pass: u32,
    read: impl Fn(&P, usize) -> Entry + Sync,
    len: impl Fn(&P) -> usize + Sync,
) -> Sorted {
    let count_digits = |part: &P| {
        let mut counts = vec![0_u32; DIGITS];
        for i in 0..len(part) {
            counts[read(part, i).digit(pass)] += 1;
        }
        counts
    };
    let mut places: Vec<Vec<u32>> = parts.par_iter().map(count_digits).collect();
    // For each digit, entries of the first part come first, then those of the second.
    let mut next = 0;
    for digit in 0..DIGITS {
        for places in &mut places {
            let count = places[digit];
            places[digit] = next;
            next += count;
        }
    }
    let out = Sorted::room_for(next as usize);
    let put = |(part, places): (&P, &mut Vec<u32>)| {
        for i in 0..len(part) {
            let entry = read(part, i);
            let place = &mut places[entry.digit(pass)];
            out.0[*place as usize].store(entry.0, Ordering::Relaxed);
            *place += 1;
        }
    };
    parts.par_iter().zip(&mut places).for_each(put);
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage_core::light_sample::hash;

    /// Compares with the standard library's stable sort, for several parts.
    #[test]
    fn entries_are_sorted_and_equal_keys_stay_in_order() {
        for (count, part) in [(0, 1), (1, 1), (20_000, 7_001), (20_000, 20_000)] {
            let key =
                |i: u32| hash(i) >> (32 - KEY_BITS) & if i.is_multiple_of(3) { 0xff } else { !0 };
            let entries: Vec<Entry> = (0..count).map(|i| Entry::new(key(i), i)).collect();
            let parts: Vec<Vec<Entry>> = entries.chunks(part).map(<[Entry]>::to_vec).collect();
            let sorted = sort(&parts);
            let found: Vec<Entry> = (0..sorted.len()).map(|i| sorted.get(i)).collect();
            let mut expected = entries;
            expected.sort_by_key(|entry| entry.key());
            assert_eq!(found, expected);
            let middle = 1 << (KEY_BITS - 1);
            let below = expected.iter().filter(|entry| entry.key() < middle).count();
            assert_eq!(sorted.entries_below(middle), below);
        }
    }
}
