//! Comparison of results word by word, in units in the last place.

use super::{COUNT, Fault, wrapper};
use std::{collections::HashMap, fmt};
use umbrage_core::Twin;

/// One input on which two halves differ.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// Difference in units in the last place, or `u64::MAX` if just one of them is NaN.
    pub ulps: u64,
    /// The input's words.
    pub input: Vec<u32>,
    /// Result of Rust.
    pub rust: Vec<u32>,
    /// Result of the GPU.
    pub wgsl: Vec<u32>,
    /// `true` for floats among the words of input and results, for printing.
    floats: [Vec<bool>; 2],
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [input, result] = &self.floats;
        write!(
            f,
            "{} ulps on {}: Rust gives ",
            self.ulps,
            spell(&self.input, input)
        )?;
        write!(
            f,
            "{}, WGSL {}",
            spell(&self.rust, result),
            spell(&self.wgsl, result)
        )
    }
}

fn spell(words: &[u32], floats: &[bool]) -> String {
    let word = |(&w, &float): (&u32, &bool)| {
        if float {
            format!("{:?}", f32::from_bits(w))
        } else {
            w.to_string()
        }
    };
    format!(
        "[{}]",
        words
            .iter()
            .zip(floats)
            .map(word)
            .collect::<Vec<_>>()
            .join(", ")
    )
}

/// Returns the difference of two words: in ulps for floats, where all NaNs are equal, and as
/// numbers for integers.
pub fn difference(a: u32, b: u32, float: bool) -> u64 {
    if !float {
        return u64::from(a.abs_diff(b));
    }
    match (f32::from_bits(a).is_nan(), f32::from_bits(b).is_nan()) {
        (true, true) => 0,
        (false, false) => ordered_bits(a).abs_diff(ordered_bits(b)),
        _ => u64::MAX,
    }
}

/// Maps floats to integers in order of value. Both zeros are equal: WGSL doesn't define which of
/// them `min` and `max` return.
fn ordered_bits(bits: u32) -> i64 {
    let magnitude = i64::from(bits & 0x7fff_ffff);
    if bits >> 31 == 1 {
        -magnitude
    } else {
        magnitude
    }
}

fn floats(types: &[&str]) -> Vec<bool> {
    types
        .iter()
        .flat_map(|t| std::iter::repeat_n(wrapper::scalar(t) == "f32", wrapper::count(t)))
        .collect()
}

/// Returns the greatest difference, or an error with the worst case if it is not allowed.
pub(super) fn compare(
    twin: &Twin,
    inputs: &[u32],
    expected: &[u32],
    got: &[u32],
) -> Result<u64, Fault> {
    let kinds = [floats(twin.parameters), floats(&[twin.result])];
    let given = kinds[0].len();
    let gives = kinds[1].len();
    let ulps = |i: usize| {
        let at = i * gives..(i + 1) * gives;
        let words = expected[at.clone()].iter().zip(&got[at]).zip(&kinds[1]);
        words
            .map(|((&a, &b), &float)| difference(a, b, float))
            .max()
            .unwrap_or(0)
    };
    let all: Vec<u64> = (0..inputs.len() / given).map(ulps).collect();
    let (worst, &most) = all
        .iter()
        .enumerate()
        .max_by_key(|&(_, u)| u)
        .unwrap_or((0, &0));
    if most <= u64::from(twin.ulps) {
        return Ok(most);
    }
    let cut = |words: &[u32], n: usize| words[worst * n..][..n].to_vec();
    let input = cut(inputs, given);
    let rust = cut(expected, gives);
    let wgsl = cut(got, gives);
    let worst = Box::new(Difference {
        ulps: most,
        input,
        rust,
        wgsl,
        floats: kinds,
    });
    let count = all.iter().filter(|&&u| u > u64::from(twin.ulps)).count();
    Err(Fault::Differs {
        twin: twin.name,
        count,
        allowed: twin.ulps,
        worst,
    })
}

/// Returns an error if less than one in a hundred results is meaningful.
pub(super) fn useful(twin: &Twin, expected: &[u32]) -> Result<(), Fault> {
    let kinds = floats(&[twin.result]);
    let is_number = |result: &[u32]| {
        let mut words = result.iter().zip(&kinds);
        words.all(|(&word, &float)| !float || !f32::from_bits(word).is_nan())
    };
    let mut counts: HashMap<&[u32], usize> = HashMap::new();
    let mut commonest = 0;
    let mut useful = 0;
    let results = expected.chunks_exact(kinds.len());
    for (numbers, result) in (1..).zip(results.filter(|result| is_number(result))) {
        let count = counts.entry(result).or_default();
        *count += 1;
        commonest = commonest.max(*count);
        useful = numbers - commonest;
        // Further results never reduce the difference.
        if useful * 100 >= COUNT {
            return Ok(());
        }
    }
    Err(Fault::Dull {
        twin: twin.name,
        useful,
    })
}
