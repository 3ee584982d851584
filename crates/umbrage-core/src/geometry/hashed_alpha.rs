//! Alpha test for pixels that are larger than a texel: mipmapped coverage against a hashed
//! threshold, after Wyman and McGuire 2017, "Hashed Alpha Testing"
//! ([`AlphaFilter::Hashed`](crate::AlphaFilter::Hashed)).
//!
//! * **Footprint.** The rays through the centres of a pixel, its right neighbour and the one below
//!   meet the triangle's plane at three uvs (`cut_out.rs`). The longer of the two steps between
//!   them, in texels, is s.
//! * If s is 1 or less, the nearest texel decides, as for rays.
//! * **Coverage.** Otherwise a pixel uses the two levels with 2^L <= s < 2^(L + 1). A texel of
//!   level L stores the opaque share of 2^L x 2^L texels. The cut-off is applied before averaging,
//!   since averaging alpha first makes thin leaves vanish. The nearest texel of each level is used.
//!   The two values are blended by (s^2 / 4^L - 1) / 3, which is 0 at the finer level and 1 at the
//!   coarser one.
//! * **Threshold.** Each level's texel, in each repeat of the texture, on each triangle has its own
//!   threshold from 0 to 1, hashed from integers. The pixel's threshold is the mean of the two
//!   levels' thresholds with the same weights, remapped to a uniform distribution (Wyman and
//!   McGuire, section 3.3). There is a hole where the coverage is less than the threshold.
//!
//! A triangle with coverage one half is therefore visible in half of its pixels, at any distance.
//! The pattern depends only on positions on the triangle. It stays in place when the camera or a
//! map moves, and blends gradually into another as they come closer. At s = 1 the transition from
//! the nearest texel is continuous.
//!
//! The arithmetic is explicit: levels are computed from a float's exponent, without logarithms, and
//! hashes use integers.
//!
//! The table begins with a word for each alpha-tested triangle in the order of ids: the row where
//! its levels begin, or 0 if the nearest texel decides. Each texture has a row for each level: its
//! width and height as the lower and the upper 16 bits; the row where its texels begin; the number
//! of the last level. Its texels follow, 8 bits each, from level 1 on. Level 0 is the texture
//! itself, whose bits are in the other table.

use crate::{
    geometry::cut_out::{WHOLE_NUMBERS, nearest_texel, texel_at},
    invalid::Invalid,
    recipe::shader::Module,
    scene::material::Texture,
};
use glam::{UVec2, Vec2};
use std::{collections::BTreeMap, sync::Arc};

/// The WGSL half. It calls [`CUT_OUT`](super::cut_out::CUT_OUT).
pub const HASHED_ALPHA: Module = crate::module!("hashed_alpha");

/// The WGSL of the test, for a pixel whose footprint is larger than a texel. It calls
/// [`HASHED_ALPHA`], [`HOLE`](super::cut_out::HOLE), and `fn coverage_row(i: u32) -> vec4u`, which
/// the shader that binds the table must declare.
pub const HASHED_HOLE: Module = crate::module!("hashed_hole");

/// Coverage texels per row of the table.
const TEXELS_A_ROW: u32 = 16;

/// Coverage of an opaque texel.
const WHOLLY_THERE: f32 = 255.0;

/// Returns the square of a pixel's extent on a texture of this size, texels: of the longer step
/// from its uv to those of the next pixels.
#[inline(always)]
pub(super) fn squared_footprint(uv: Vec2, right: Vec2, below: Vec2, size: UVec2) -> f32 {
    let across = (right - uv) * size.as_vec2();
    let down = (below - uv) * size.as_vec2();
    let squared_across = across.x * across.x + across.y * across.y;
    let squared_down = down.x * down.x + down.y * down.y;
    if squared_across > squared_down {
        squared_across
    } else {
        squared_down
    }
}

/// Returns the finer of the two levels around a footprint, given its square, 1 or more: half the
/// exponent is the logarithm of its root. At most `last`.
#[inline(always)]
fn finer_level(squared: f32, last: u32) -> u32 {
    let exponent = (squared.to_bits() >> 23).wrapping_sub(127);
    (exponent >> 1).min(last)
}

/// Returns the position of a footprint between a level and the next, 0 to 1, given its square.
/// Subtracts twice the level from the exponent.
#[inline(always)]
fn part_to_next_level(squared: f32, level: u32) -> f32 {
    let scaled = f32::from_bits(squared.to_bits().wrapping_sub(level << 24));
    (scaled - 1.0) / 3.0
}

/// Returns the number of whole repeats before a texture coordinate; 0 where the coordinate is not
/// finite.
#[inline(always)]
fn whole_repeats(t: f32) -> i32 {
    if t.abs() < WHOLE_NUMBERS {
        t.floor() as i32
    } else {
        0
    }
}

/// Returns the threshold of the texel that contains a uv, in a level of this size: more than 0,
/// less than 1.
#[inline(always)]
fn cell_threshold(uv: Vec2, size: UVec2, level: u32, triangle: u32) -> f32 {
    let repeats = [uv.x, uv.y].map(|t| whole_repeats(t).cast_unsigned());
    let column = repeats[0]
        .wrapping_mul(size.x)
        .wrapping_add(nearest_texel(uv.x, size.x));
    let row = repeats[1]
        .wrapping_mul(size.y)
        .wrapping_add(nearest_texel(uv.y, size.y));
    // 23 bits plus one half: exact.
    ((mixed_words(column, row, level, triangle) >> 9) as f32 + 0.5) * 1.192_092_9e-7
}

/// Mixes four words into one: the first word of `pcg4d` (Jarzynski and Olano 2020, "Hash Functions
/// for GPU Rendering").
#[inline(always)]
fn mixed_words(column: u32, row: u32, level: u32, triangle: u32) -> u32 {
    let [mut x, mut y, mut z, mut w] = [column, row, level, triangle]
        .map(|word| word.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    x = x.wrapping_add(y.wrapping_mul(w));
    y = y.wrapping_add(z.wrapping_mul(x));
    z = z.wrapping_add(x.wrapping_mul(y));
    w = w.wrapping_add(y.wrapping_mul(z));
    x ^= x >> 16;
    y ^= y >> 16;
    w ^= w >> 16;
    x.wrapping_add(y.wrapping_mul(w))
}

/// Returns the threshold `part` of the way between those of two levels, remapped to a uniform
/// distribution. The weighted mean of two uniform numbers has a trapezoidal distribution; this is
/// its integral, piece by piece.
#[inline(always)]
fn threshold_between(fine: f32, coarse: f32, part: f32) -> f32 {
    let rest = 1.0 - part;
    let mixed = fine * rest + coarse * part;
    let lesser = part.min(rest);
    let greater = part.max(rest);
    let twice = 2.0 * lesser * greater;
    if mixed < lesser {
        return mixed * mixed / twice;
    }
    if mixed < greater {
        return (mixed - 0.5 * lesser) / greater;
    }
    let to_one = 1.0 - mixed;
    1.0 - to_one * to_one / twice
}

/// Mipmapped coverages of alpha textures.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Coverage {
    rows: Arc<[[u32; 4]]>,
}

/// The mipmap levels of one texture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Levels<'a> {
    rows: &'a [[u32; 4]],
    /// The row of the first level.
    first: u32,
}

/// Table entry of a level.
#[derive(Clone, Copy, Debug)]
struct Level {
    size: UVec2,
    /// The row at which the level's texels begin.
    row: u32,
    /// The number of the last level.
    last: u32,
}

impl Level {
    fn of_row(words: [u32; 4]) -> Self {
        let size = words[0];
        Self {
            size: UVec2::new(size & 0xffff, size >> 16),
            row: words[1],
            last: words[2],
        }
    }

    fn to_row(self) -> [u32; 4] {
        [self.size.x | self.size.y << 16, self.row, self.last, 0]
    }
}

impl Levels<'_> {
    fn level(&self, number: u32) -> Level {
        Level::of_row(self.rows[(self.first + number) as usize])
    }

    /// Returns whether there is a hole at a uv where the square of the footprint is `squared`, more
    /// than 1. `is_clear` returns whether a texel of level 0 is clear.
    pub(super) fn is_hole(
        &self,
        uv: Vec2,
        squared: f32,
        triangle: u32,
        is_clear: impl Fn(u32) -> bool,
    ) -> bool {
        let last = self.level(0).last;
        let level = finer_level(squared, last);
        let [fine, fine_threshold] = self.coverage_and_threshold(uv, level, triangle, &is_clear);
        if level == last {
            return fine < WHOLLY_THERE * fine_threshold;
        }
        let [coarse, coarse_threshold] =
            self.coverage_and_threshold(uv, level + 1, triangle, &is_clear);
        let part = part_to_next_level(squared, level);
        let coverage = fine + (coarse - fine) * part;
        coverage < WHOLLY_THERE * threshold_between(fine_threshold, coarse_threshold, part)
    }

    /// Returns the coverage at a uv, 0 to [`WHOLLY_THERE`], and the threshold of its texel.
    fn coverage_and_threshold(
        &self,
        uv: Vec2,
        number: u32,
        triangle: u32,
        is_clear: impl Fn(u32) -> bool,
    ) -> [f32; 2] {
        let level = self.level(number);
        let texel = texel_at(uv, level.size);
        let threshold = cell_threshold(uv, level.size, number, triangle);
        if number == 0 {
            let coverage = if is_clear(texel) { 0.0 } else { WHOLLY_THERE };
            return [coverage, threshold];
        }
        let row = self.rows[(level.row + texel / TEXELS_A_ROW) as usize];
        let word = row[(texel / 4 % 4) as usize];
        let coverage = word >> (8 * (texel % 4)) & 255;
        [coverage as f32, threshold]
    }
}

impl Coverage {
    /// Returns the table.
    pub(super) fn rows(&self) -> &Arc<[[u32; 4]]> {
        &self.rows
    }

    /// Returns the levels of the texture of alpha-tested triangle `record`; `None` if the nearest
    /// texel decides.
    pub(super) fn levels_of(&self, record: u32) -> Option<Levels<'_>> {
        let first = self.rows[record as usize / 4][record as usize % 4];
        (first != 0).then_some(Levels {
            rows: &self.rows,
            first,
        })
    }

    /// Restores coverages from a table, for alpha-tested triangles with textures of these sizes.
    /// `None` if the table is empty.
    ///
    /// # Errors
    /// Errors if it is not a table as returned by
    /// [`CutOuts::coverage_rows`](crate::CutOuts::coverage_rows).
    #[cfg(feature = "serde")]
    pub(super) fn from_rows(rows: &[[u32; 4]], sizes: &[UVec2]) -> Result<Option<Self>, Invalid> {
        if rows.is_empty() {
            return Ok(None);
        }
        let bad = |why: &str| Invalid::new("geometry's coverages", why, "write it again");
        let heads = rows.get(..sizes.len().div_ceil(4));
        let heads = heads.ok_or_else(|| bad("are shorter than their list of triangles"))?;
        for (&first, &size) in heads.as_flattened().iter().zip(sizes) {
            if first != 0 && !are_levels(rows, first as usize, size) {
                return Err(bad("have levels that don't fit their texture or the table"));
            }
        }
        Ok(Some(Self { rows: rows.into() }))
    }
}

/// Returns whether the levels of a texture of this size begin at a row of a table.
#[cfg(feature = "serde")]
fn are_levels(rows: &[[u32; 4]], first: usize, size: UVec2) -> bool {
    let last = last_level(size);
    let mut size = size;
    for number in 0..=last {
        let Some(&row) = rows.get(first + number as usize) else {
            return false;
        };
        let level = Level::of_row(row);
        let texels = u64::from(size.x) * u64::from(size.y);
        let end = u64::from(level.row) + texels.div_ceil(u64::from(TEXELS_A_ROW));
        let ends_within = number == 0 || end <= rows.len() as u64;
        if level.size != size || level.last != last || !ends_within {
            return false;
        }
        size = half_size(size);
    }
    true
}

/// Returns the number of the level that has one texel.
fn last_level(size: UVec2) -> u32 {
    size.max_element().max(1).ilog2()
}

/// Returns the size of the next level: sides are halved and rounded down, but at least 1.
fn half_size(size: UVec2) -> UVec2 {
    (size / 2).max(UVec2::ONE)
}

/// Builder of a [`Coverage`].
pub(super) struct CoverageBuilder {
    rows: Vec<[u32; 4]>,
    /// First row of the levels of each texture, for each cut-off used with it.
    places: BTreeMap<(usize, u32), usize>,
}

impl CoverageBuilder {
    /// Begins a table for this number of alpha-tested triangles.
    pub(super) fn new(triangles: usize) -> Self {
        Self {
            rows: vec![[0; 4]; triangles.div_ceil(4)],
            places: BTreeMap::new(),
        }
    }

    /// Enables hashed alpha for a triangle. `key` is the texture's index and the bits of the
    /// cut-off.
    pub(super) fn add(&mut self, triangle: usize, key: (usize, u32), texture: &Texture) {
        let rows = &mut self.rows;
        let first = *self
            .places
            .entry(key)
            .or_insert_with(|| append_levels(rows, texture, f32::from_bits(key.1)));
        // The range is checked by `finish`.
        self.rows[triangle / 4][triangle % 4] = first as u32;
    }

    /// Returns the table; `None` if nothing was added.
    ///
    /// # Errors
    /// Errors if it has too many rows.
    pub(super) fn finish(self) -> Result<Option<Coverage>, Invalid> {
        if self.places.is_empty() {
            return Ok(None);
        }
        if u32::try_from(self.rows.len()).is_err() {
            let why = "have more texels than fit in a table";
            return Err(Invalid::new("alpha textures", why, "use smaller textures"));
        }
        let rows = self.rows.into();
        Ok(Some(Coverage { rows }))
    }
}

/// Appends the levels of a texture, and returns the row at which they begin.
fn append_levels(rows: &mut Vec<[u32; 4]>, texture: &Texture, cutoff: f32) -> usize {
    let first = rows.len();
    let last = last_level(texture.size);
    rows.resize(first + last as usize + 1, [0; 4]);
    let is_there = |texel: [f32; 4]| f32::from(u8::from(texel[3] >= cutoff));
    let mut coverages: Vec<f32> = texture.texels.iter().map(is_there).collect();
    let mut size = texture.size;
    let mut row = 0;
    for number in 0..=last {
        let level = Level { size, row, last };
        rows[first + number as usize] = level.to_row();
        if number > 0 {
            append_texels(rows, &coverages);
        }
        let next = half_size(size);
        coverages = shrink_coverages(&coverages, size, next);
        size = next;
        row = rows.len() as u32;
    }
    first
}

/// Appends coverages from 0 to 1 as 8 bits each.
fn append_texels(rows: &mut Vec<[u32; 4]>, coverages: &[f32]) {
    for texels in coverages.chunks(TEXELS_A_ROW as usize) {
        let mut row = [0; 4];
        for (i, coverage) in texels.iter().enumerate() {
            let byte = (coverage * WHOLLY_THERE).round() as u32;
            row[i / 4] |= byte << (8 * (i % 4));
        }
        rows.push(row);
    }
}

/// Downsamples a level to the size of the next one. Averages by area, since sides may be odd.
fn shrink_coverages(coverages: &[f32], from: UVec2, to: UVec2) -> Vec<f32> {
    let [width, height] = from.to_array().map(|n| n as usize);
    let columns = shares(from.x, to.x);
    let rows = shares(from.y, to.y);
    let mut narrow = Vec::with_capacity(columns.len() * height);
    for line in coverages.chunks_exact(width) {
        narrow.extend(
            columns
                .iter()
                .map(|shares| weighted_coverage(shares, |x| line[x])),
        );
    }
    let mut out = Vec::with_capacity(columns.len() * rows.len());
    for shares in &rows {
        for x in 0..columns.len() {
            out.push(weighted_coverage(shares, |y| narrow[y * columns.len() + x]));
        }
    }
    out
}

/// Texels of a line, and the weight of each.
type Shares = Vec<(usize, f32)>;

fn weighted_coverage(shares: &Shares, coverage: impl Fn(usize) -> f32) -> f32 {
    shares.iter().map(|&(i, share)| share * coverage(i)).sum()
}

/// Returns the texels of a line of `from` texels in each of `to` equal parts, and their share of
/// the part.
fn shares(from: u32, to: u32) -> Vec<Shares> {
    let length = f64::from(from) / f64::from(to);
    let part = |i: u32| {
        let begin = f64::from(i) * length;
        let end = f64::from(i + 1) * length;
        let last = (end.ceil() as u32).min(from);
        let texels = begin as u32..last;
        let share = |k: u32| {
            let common = end.min(f64::from(k + 1)) - begin.max(f64::from(k));
            (k as usize, (common.max(0.0) / length) as f32)
        };
        texels.map(share).collect()
    };
    (0..to).map(part).collect()
}

/// The twins, for the lockstep tests.
#[cfg(feature = "testing")]
pub const TWINS: &[crate::recipe::twin::Twin] = {
    use crate::geometry::cut_out::CUT_OUT;
    use crate::geometry::{ray_box::RAY_BOX, ray_triangle::RAY_TRIANGLE};
    &[
        crate::twin!(HASHED_ALPHA, squared_footprint(uv: Vec2, right: Vec2, below: Vec2, size: UVec2) -> f32, needs [RAY_BOX, RAY_TRIANGLE, CUT_OUT]),
        crate::twin!(HASHED_ALPHA, finer_level(squared: f32, last: u32) -> u32, needs [RAY_BOX, RAY_TRIANGLE, CUT_OUT]),
        crate::twin!(HASHED_ALPHA, part_to_next_level(squared: f32, level: u32) -> f32, needs [RAY_BOX, RAY_TRIANGLE, CUT_OUT]),
        crate::twin!(HASHED_ALPHA, cell_threshold(uv: Vec2, size: UVec2, level: u32, triangle: u32) -> f32, needs [RAY_BOX, RAY_TRIANGLE, CUT_OUT]),
        crate::twin!(HASHED_ALPHA, threshold_between(fine: f32, coarse: f32, part: f32) -> f32, needs [RAY_BOX, RAY_TRIANGLE, CUT_OUT]),
    ]
};

#[cfg(test)]
#[path = "hashed_alpha_tests.rs"]
mod tests;
