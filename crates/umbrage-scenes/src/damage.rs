//! Damaged copies of a text, for tests of parsers.

use crate::builtin::noise::hash;
use umbrage_core::glam::IVec3;

/// Replacements that are difficult for parsers.
const ODD: &[&[u8]] = &[
    b"",
    b"\n",
    b"\r",
    b"-",
    b"0",
    b"9999999999",
    b"1e39",
    b"nan",
    b"-inf",
    b"/",
    b"\\",
    b"#",
    b"[",
    b"]",
    b"\"",
    b"=",
    b"f ",
    b"v ",
    b"\xff",
    b"\0",
    b".",
    b" ",
    b"_",
    b"x",
];

/// Returns `count` copies, each with one to three short pieces replaced, equal in every run.
pub(crate) fn damaged_texts(text: &str, count: i32) -> impl Iterator<Item = Vec<u8>> {
    (0..count).map(move |i| {
        let mut bytes = text.as_bytes().to_vec();
        let pick = |what: i32, of: usize| hash(IVec3::new(i, what, 99)) as usize % of;
        for cut in 0..1 + pick(0, 3) as i32 {
            let start = pick(4 * cut + 1, bytes.len() + 1);
            let end = (start + pick(4 * cut + 2, 4)).min(bytes.len());
            bytes.splice(
                start..end,
                ODD[pick(4 * cut + 3, ODD.len())].iter().copied(),
            );
        }
        bytes
    })
}
