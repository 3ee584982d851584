//! What a list item says of its caster beside its name, in one word: its box in the cell and its
//! least depth, each in 32 steps. One subtraction compares all of them with a receiver's.
//!
//! A word has five fields of six bits: least across, least down, 31 less greatest across, 31 less
//! greatest down, and depth, from the lowest bits on. An item's are 0 to 31, and a receiver's
//! likewise with 32 more. A field of the difference is 32 or more where the receiver's number is at
//! least the item's, and always above 0, so no field borrows from the next (Lamport 1975, "Multiple
//! Byte Processing with Full-Word Instructions"). A caster may be in a receiver's way only where
//! all fields are.

/// Steps of each number, as a power of two.
pub(super) const KEY_STEPS_LOG2: u32 = 5;

/// Steps of each number.
pub(super) const KEY_STEPS: f32 = (1 << KEY_STEPS_LOG2) as f32;

/// Bits of a field.
const FIELD: u32 = 6;

/// The greatest number of a field.
const LAST: u32 = 31;

/// The bit of each field that says 32.
const GUARDS: u32 = 1 << 5 | 1 << 11 | 1 << 17 | 1 << 23 | 1 << 29;

/// That of depth.
const DEPTH_GUARD: u32 = 1 << 29;

/// A box in a cell, in steps.
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

/// Returns the word with which receivers in this box, and as deep as this, ask items: all below 32.
#[inline(always)]
pub(super) fn asking_word(bounds: CellBox, depth: u32) -> u32 {
    let [x0, y0] = bounds.low;
    let [x1, y1] = bounds.high;
    let fields = x1
        | y1 << FIELD
        | (LAST - x0) << (2 * FIELD)
        | (LAST - y0) << (3 * FIELD)
        | depth << (4 * FIELD);
    fields | GUARDS
}

/// Returns whether an item's caster is deeper than receivers, and so are all after it in its list.
#[inline(always)]
pub(super) fn ends_list(item: u32, asking: u32) -> bool {
    (asking - item) & DEPTH_GUARD == 0
}

/// Returns whether an item's caster may be in the way of receivers.
#[inline(always)]
pub(super) fn may_hide(item: u32, asking: u32) -> bool {
    (asking - item) & GUARDS == GUARDS
}

#[cfg(test)]
mod tests {
    use super::*;
    use umbrage_core::light_sample::hash;

    /// The word says what its numbers say one by one.
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
            let [item, asking] = [random_box(0), random_box(4)];
            let [item_depth, depth] = [number(8), number(9)];
            let overlap = |axis: usize| {
                item.low[axis] <= asking.high[axis] && item.high[axis] >= asking.low[axis]
            };
            let expected = overlap(0) && overlap(1) && item_depth <= depth;
            let found = may_hide(item_word(item, item_depth), asking_word(asking, depth));
            assert_eq!(found, expected, "{item:?} {item_depth}, {asking:?} {depth}");
            let ends = ends_list(item_word(item, item_depth), asking_word(asking, depth));
            assert_eq!(ends, item_depth > depth);
            hidden += u32::from(found);
        }
        assert!(
            (5_000..60_000).contains(&hidden),
            "the test tells little: {hidden}"
        );
    }
}
