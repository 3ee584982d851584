//! Key of a list item: the caster's box in the cell and its least depth in one word, each in 32
//! steps. One subtraction compares all of them with a receiver's.
//!
//! A word has five fields of six bits, from the lowest bits on: least across, least down, 31 minus
//! greatest across, 31 minus greatest down, and depth. An item's values are 0 to 31. A receiver's
//! are likewise, plus 32. A field of the difference is 32 or more if the receiver's value is at
//! least the item's. It is always above 0, so no field borrows from the next (Lamport 1975,
//! "Multiple Byte Processing with Full-Word Instructions"). A caster may block a receiver only if
//! this holds for all fields.

use umbrage_core::{Module, module};

/// WGSL half.
pub(super) const ITEM_KEY: Module = module!("item_key");

/// Number of steps of each value, as a power of two.
pub(super) const KEY_STEPS_LOG2: u32 = 5;

/// Number of steps of each value.
pub(super) const KEY_STEPS: f32 = (1 << KEY_STEPS_LOG2) as f32;

/// Number of bits of a field.
const FIELD: u32 = 6;

/// Greatest value of a field.
const LAST: u32 = 31;

/// Bit of value 32 in each field.
const GUARDS: u32 = 1 << 5 | 1 << 11 | 1 << 17 | 1 << 23 | 1 << 29;

/// Bit of value 32 in the depth field.
const DEPTH_GUARD: u32 = 1 << 29;

/// Box in a cell, in steps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct CellBox {
    /// Least step across, and down.
    pub(super) low: [u32; 2],
    /// Greatest step, inclusive.
    pub(super) high: [u32; 2],
}

/// Returns the word of an item with this box and least depth, all below 32.
#[inline(always)]
pub(super) fn item_word(bounds: CellBox, depth: u32) -> u32 {
    let [x0, y0] = bounds.low;
    let [x1, y1] = bounds.high;
    x0 | y0 << FIELD
        | (LAST - x1) << (2 * FIELD)
        | (LAST - y1) << (3 * FIELD)
        | depth << (4 * FIELD)
}

/// Returns the query word of receivers in this box with this greatest depth, all below 32.
#[inline(always)]
pub(super) fn receiver_word(bounds: CellBox, depth: u32) -> u32 {
    let [x0, y0] = bounds.low;
    let [x1, y1] = bounds.high;
    let fields = x1
        | y1 << FIELD
        | (LAST - x0) << (2 * FIELD)
        | (LAST - y0) << (3 * FIELD)
        | depth << (4 * FIELD);
    fields | GUARDS
}

/// Returns whether an item's caster, and so all after it in its list, are deeper than the
/// receivers.
#[inline(always)]
pub(super) fn ends_list(item: u32, querying: u32) -> bool {
    (querying - item) & DEPTH_GUARD == 0
}

/// Returns whether an item's caster may block receivers.
#[inline(always)]
pub(super) fn may_hide(item: u32, querying: u32) -> bool {
    (querying - item) & GUARDS == GUARDS
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage_core::light_sample::hash;

    /// The comparison of words equals that of their fields.
    #[test]
    fn one_subtraction_compares_all_fields() {
        let mut hidden = 0;
        for i in 0..100_000_u32 {
            let number = |k: u32| hash(16 * i + k) % 32;
            let pair = |k: u32| [number(k).min(number(k + 1)), number(k).max(number(k + 1))];
            let random_box = |k: u32| {
                let [x0, x1] = pair(k);
                let [y0, y1] = pair(k + 2);
                CellBox {
                    low: [x0, y0],
                    high: [x1, y1],
                }
            };
            let [item, querying] = [random_box(0), random_box(4)];
            let [item_depth, depth] = [number(8), number(9)];
            let overlap = |axis: usize| {
                item.low[axis] <= querying.high[axis] && item.high[axis] >= querying.low[axis]
            };
            let expected = overlap(0) && overlap(1) && item_depth <= depth;
            let found = may_hide(item_word(item, item_depth), receiver_word(querying, depth));
            assert_eq!(
                found, expected,
                "{item:?} {item_depth}, {querying:?} {depth}"
            );
            let ends = ends_list(item_word(item, item_depth), receiver_word(querying, depth));
            assert_eq!(ends, item_depth > depth);
            hidden += u32::from(found);
        }
        assert!(
            (5_000..60_000).contains(&hidden),
            "too few hidden cases: {hidden}"
        );
    }
}
