//! Image metrics: how far a mask is from the truth, and how well two masks agree.
//!
//! Masks hold visibility 0..=1, rows from the top. Every comparator refuses masks of the wrong size
//! and masks that hold NaN or anything else outside 0..=1, rather than averaging it away.

mod causes;

pub use crate::metrics::causes::{CONTACT, Cause, Causes, TruthImage, attribute, is_penumbra};

use crate::invalid::Invalid;
use glam::UVec2;

/// A pixel is a **false shadow** when the mask is darker than truth by more than this, **false
/// light** when it is lighter by more: a quarter of the light, a step that anyone sees. (For hard
/// masks and ideal lights any threshold in 0..1 gives the same figures.)
pub const ERROR_THRESHOLD: f32 = 0.25;

/// A false shadow is **acne** when it lies farther than this from any true shadow edge, in pixels
/// between centres.
pub const ACNE_DISTANCE: u32 = 8;

/// Truth counts as penumbra, and so as a shadow edge, from this value to one less it.
pub const PENUMBRA: f32 = 0.02;

/// Decided pixels of two masks may differ by this: one step of an 8-bit image.
pub const AGREEMENT_TOLERANCE: f32 = 1.0 / 255.0;

/// What a pixel is to the error figures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Pixel {
    /// Counted.
    #[default]
    Counted,
    /// Shows nothing, or something that takes no shadows.
    Empty,
    /// Faces wholly away from the light, or lies outside a spot's cone: shading darkens it anyway.
    Unlit,
    /// Truth itself is numerically ambiguous there.
    Ambiguous,
    /// The mask's backend sees another triangle there than truth, as its device moves vertices to
    /// another grid.
    Elsewhere,
    /// Would count, but only a sample of the pixels is judged, and this one is not in it. Truth is
    /// a preview there.
    Unsampled,
}

impl Pixel {
    /// Whether the pixel counts, or would if it were in the sample that is judged.
    pub fn is_candidate(self) -> bool {
        matches!(self, Self::Counted | Self::Unsampled)
    }
}

/// How far a mask is from the truth. Shares are percentages of the counted pixels, 0..=100; all
/// figures are 0 when no pixel counts.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Errors {
    /// Root of the mean square of mask - truth, 0..=1.
    pub rmse: f64,
    /// Mean of |mask - truth|, 0..=1.
    pub mean: f64,
    /// Mean of mask - truth, -1..=1: positive means too light.
    pub bias: f64,
    /// Greatest |mask - truth|, 0..=1.
    pub largest: f64,
    /// Mask darker than truth by more than [`ERROR_THRESHOLD`], percent.
    pub false_shadow: f64,
    /// Mask lighter than truth by more than [`ERROR_THRESHOLD`], percent.
    pub false_light: f64,
    /// False shadow farther than [`ACNE_DISTANCE`] from any true shadow edge, percent.
    pub acne: f64,
    /// Pixels counted.
    pub counted: u64,
    /// Pixels left out: truth is ambiguous.
    pub ambiguous: u64,
    /// Pixels left out: they face away from the light or lie outside its cone.
    pub unlit: u64,
    /// Pixels left out: the backend sees another triangle there than truth.
    #[cfg_attr(feature = "serde", serde(default))]
    pub elsewhere: u64,
    /// Pixels left out: only a sample of the pixels is judged.
    #[cfg_attr(feature = "serde", serde(default))]
    pub unsampled: u64,
    /// Standard error of `rmse`, as only a sample of the pixels is judged; 0 where all are. It is
    /// also 0, and bounds nothing, where fewer than two pixels are judged or none of them is wrong.
    #[cfg_attr(feature = "serde", serde(default))]
    pub rmse_error: f64,
}

/// Truth, ready to be compared with many masks.
#[derive(Clone, Debug)]
pub struct ReferenceMask<'a> {
    size: UVec2,
    truth: &'a [f32],
    pixels: &'a [Pixel],
    near_edge: Vec<bool>,
}

impl<'a> ReferenceMask<'a> {
    /// Finds truth's shadow edges, `pixels` telling what counts. A true shadow edge is where truth
    /// is a penumbra or differs from one of the four neighbours' by more than [`ERROR_THRESHOLD`];
    /// pixels that are [`Pixel::Empty`] make no edges.
    ///
    /// # Errors
    /// When sizes differ or a value is not within 0..=1.
    pub fn new(size: UVec2, truth: &'a [f32], pixels: &'a [Pixel]) -> Result<Self, Invalid> {
        check("truth", size, truth)?;
        check_len("pixel classes", size, pixels.len())?;
        let near_edge = near(size, &edges(size, truth, pixels), ACNE_DISTANCE);
        Ok(Self {
            size,
            truth,
            pixels,
            near_edge,
        })
    }

    /// The same truth for a backend for which other pixels count; shadow edges stay where they are.
    ///
    /// # Errors
    /// When there is not one class a pixel.
    pub fn with_pixels<'b>(&'b self, pixels: &'b [Pixel]) -> Result<ReferenceMask<'b>, Invalid> {
        check_len("pixel classes", self.size, pixels.len())?;
        Ok(ReferenceMask {
            pixels,
            ..self.clone()
        })
    }

    /// How far a mask is from it.
    ///
    /// # Errors
    /// When sizes differ or a value is not within 0..=1.
    pub fn errors(&self, mask: &[f32]) -> Result<Errors, Invalid> {
        check("mask", self.size, mask)?;
        let mut out = Errors::default();
        let mut sum_of_squares = 0.0;
        let mut sum_of_fourth_powers = 0.0;
        for (i, pixel) in self.pixels.iter().enumerate() {
            match pixel {
                Pixel::Counted => {
                    out.add(mask[i], self.truth[i], self.near_edge[i]);
                    let square = (f64::from(mask[i]) - f64::from(self.truth[i])).powi(2);
                    sum_of_squares += square;
                    sum_of_fourth_powers += square * square;
                }
                Pixel::Empty => {}
                Pixel::Unlit => out.unlit += 1,
                Pixel::Ambiguous => out.ambiguous += 1,
                Pixel::Elsewhere => out.elsewhere += 1,
                Pixel::Unsampled => out.unsampled += 1,
            }
        }
        let n = out.counted.max(1) as f64;
        let mean_square = sum_of_squares / n;
        out.rmse = mean_square.sqrt();
        out.rmse_error = out.rmse_error_of(mean_square, sum_of_fourth_powers / n);
        out.mean /= n;
        out.bias /= n;
        for share in [&mut out.false_shadow, &mut out.false_light, &mut out.acne] {
            *share *= 100.0 / n;
        }
        Ok(out)
    }
}

impl Errors {
    /// Compares a single mask with truth; many are compared quicker by a [`ReferenceMask`].
    ///
    /// # Errors
    /// When sizes differ or a value is not within 0..=1.
    pub fn measure(
        size: UVec2,
        mask: &[f32],
        truth: &[f32],
        pixels: &[Pixel],
    ) -> Result<Self, Invalid> {
        ReferenceMask::new(size, truth, pixels)?.errors(mask)
    }

    /// Returns the standard error of the root of `mean_square`, given the mean of the squares'
    /// squares: that of a mean of `counted` out of a finite number of pixels (Cochran 1977,
    /// "Sampling techniques", 2.6), carried through the root to first order. Pixels are drawn one
    /// from each block, which errs less than pixels drawn at random.
    fn rmse_error_of(&self, mean_square: f64, mean_fourth_power: f64) -> f64 {
        if self.unsampled == 0 || self.counted < 2 || mean_square == 0.0 {
            return 0.0;
        }
        let counted = self.counted as f64;
        let share_left_out = self.unsampled as f64 / (counted + self.unsampled as f64);
        // That of a population of which these are a sample has one degree of freedom less.
        let variance = (mean_fourth_power - mean_square * mean_square).max(0.0);
        let error_of_mean = (variance / (counted - 1.0) * share_left_out).sqrt();
        error_of_mean / (2.0 * mean_square.sqrt())
    }

    /// Adds one pixel to the sums.
    fn add(&mut self, mask: f32, truth: f32, near_edge: bool) {
        let difference = mask - truth;
        self.counted += 1;
        self.mean += f64::from(difference.abs());
        self.bias += f64::from(difference);
        self.largest = self.largest.max(f64::from(difference.abs()));
        if difference < -ERROR_THRESHOLD {
            self.false_shadow += 1.0;
            self.acne += if near_edge { 0.0 } else { 1.0 };
        }
        if difference > ERROR_THRESHOLD {
            self.false_light += 1.0;
        }
    }
}

/// Returns which pixels lie on true shadow edges, as [`Errors::measure`] defines them.
pub fn edges(size: UVec2, truth: &[f32], pixels: &[Pixel]) -> Vec<bool> {
    let width = size.x as usize;
    let height = size.y as usize;
    let differs = |i: usize, j: usize| {
        pixels[j] != Pixel::Empty && (truth[i] - truth[j]).abs() > ERROR_THRESHOLD
    };
    let mut is_edge = vec![false; width * height];
    for (i, is_edge) in is_edge.iter_mut().enumerate() {
        let x = i % width;
        let y = i / width;
        *is_edge = pixels[i] != Pixel::Empty
            && ((PENUMBRA..=1.0 - PENUMBRA).contains(&truth[i])
                || (x > 0 && differs(i, i - 1))
                || (x + 1 < width && differs(i, i + 1))
                || (y > 0 && differs(i, i - width))
                || (y + 1 < height && differs(i, i + width)));
    }
    is_edge
}

/// Returns whether each pixel lies within `distance` (Euclidean, between centres, in pixels) of a
/// set pixel: an exact distance transform cut off at `distance`, columns first, then rows.
pub fn near(size: UVec2, set: &[bool], distance: u32) -> Vec<bool> {
    let width = size.x as usize;
    let column_distance = distances_in_columns(size, set, distance);
    let reach = distance as usize;
    let limit_squared = u64::from(distance) * u64::from(distance);
    let mut near = vec![false; column_distance.len()];
    for (i, near) in near.iter_mut().enumerate() {
        let x = i % width;
        let row = i - x;
        let first = x.saturating_sub(reach);
        let last = (x + reach).min(width - 1);
        *near = (first..=last).any(|k| {
            let dx = k.abs_diff(x) as u64;
            let dy = u64::from(column_distance[row + k]);
            dx * dx + dy * dy <= limit_squared
        });
    }
    near
}

/// Returns each pixel's distance to the nearest set pixel of its column, pixels; at most
/// `distance + 1`.
fn distances_in_columns(size: UVec2, set: &[bool], distance: u32) -> Vec<u32> {
    let width = size.x as usize;
    let height = size.y as usize;
    let far = distance + 1;
    let mut distances = vec![far; width * height];
    for x in 0..width {
        // Down from the last set pixel above, then up from the last set pixel below.
        let mut above = far;
        for i in (0..height).map(|y| y * width + x) {
            above = if set[i] { 0 } else { (above + 1).min(far) };
            distances[i] = above;
        }
        let mut below = far;
        for i in (0..height).rev().map(|y| y * width + x) {
            below = if set[i] { 0 } else { (below + 1).min(far) };
            distances[i] = distances[i].min(below);
        }
    }
    distances
}

/// Why two masks may differ at a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Doubt {
    /// They may not: the answer there is decided.
    #[default]
    None,
    /// Rounding decides the answer there.
    Rounding,
    /// Their backends see different triangles there.
    Triangle,
}

/// The share of the pixels compared that may differ because of rounding. Rounding decides along the
/// edges of texels and where a surface shadows itself; were it more, a fault of the bias or of the
/// light space could hide in it.
pub const MAX_UNDECIDED_SHARE: f64 = 0.001;

/// How much a device's rounding may add to a mask's RMSE against truth ([`Agreement::excess`]): a
/// bias that is too small for it darkens whole surfaces, which adds tenths; edges that move by a
/// part of a pixel add thousandths.
pub const MAX_EXCESS_RMSE: f64 = 0.005;

/// How well a mask agrees with the CPU's of the same view.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Agreement {
    /// Pixels compared.
    pub compared: u64,
    /// Pixels that are not equal, however little they differ.
    pub differing: u64,
    /// Pixels that differ by more than is allowed, which [`Doubt::Rounding`] excuses.
    pub undecided: u64,
    /// Pixels that differ by more than is allowed, which [`Doubt::Triangle`] excuses.
    pub elsewhere: u64,
    /// Greatest difference anywhere, 0..=1.
    pub largest: f64,
    /// Decided pixels that differ by more than [`AGREEMENT_TOLERANCE`]: must be 0.
    pub violations: u64,
    /// Pixels on which the CPU's own mask changes by more than is allowed once it rounds vertices
    /// as the other backend's device does ([`Snapping`](crate::Snapping)). There the other backend
    /// must agree with the changed mask.
    #[cfg_attr(feature = "serde", serde(default))]
    pub by_grid: u64,
    /// How much greater the mask's RMSE against truth is than that of the CPU's mask over the same
    /// pixels; 0 if nobody measured it.
    #[cfg_attr(feature = "serde", serde(default))]
    pub excess: f64,
}

impl Agreement {
    /// Compares two masks; `doubts` tells where they may differ, `tolerance` is what the kernel
    /// allows beyond [`AGREEMENT_TOLERANCE`], 0..=1: comparison samplers' weights are left to
    /// devices, say.
    ///
    /// # Errors
    /// When sizes differ or a value is not within 0..=1.
    pub fn measure(
        size: UVec2,
        a: &[f32],
        b: &[f32],
        doubts: &[Doubt],
        tolerance: f32,
    ) -> Result<Self, Invalid> {
        check("first mask", size, a)?;
        check("second mask", size, b)?;
        check_len("doubts", size, doubts.len())?;
        let mut out = Self {
            compared: a.len() as u64,
            ..Self::default()
        };
        for ((&a, &b), doubt) in a.iter().zip(b).zip(doubts) {
            let difference = (a - b).abs();
            out.differing += u64::from(a != b);
            out.largest = out.largest.max(f64::from(difference));
            let count = match doubt {
                Doubt::None => &mut out.violations,
                Doubt::Rounding => &mut out.undecided,
                Doubt::Triangle => &mut out.elsewhere,
            };
            *count += u64::from(difference > AGREEMENT_TOLERANCE + tolerance);
        }
        Ok(out)
    }

    /// Whether all decided pixels agree.
    pub fn holds(&self) -> bool {
        self.violations == 0
    }

    /// Whether the mask is no farther from truth than the CPU's and [`MAX_EXCESS_RMSE`].
    pub fn is_accurate(&self) -> bool {
        self.excess <= MAX_EXCESS_RMSE
    }

    /// Whether no more pixels are excused by rounding than [`MAX_UNDECIDED_SHARE`] allows.
    pub fn is_decided(&self) -> bool {
        self.undecided as f64 <= MAX_UNDECIDED_SHARE * self.compared as f64
    }
}

fn check(what: &str, size: UVec2, mask: &[f32]) -> Result<(), Invalid> {
    check_len(what, size, mask.len())?;
    match mask.iter().position(|v| !(0.0..=1.0).contains(v)) {
        None => Ok(()),
        Some(i) => {
            let why = format!(
                "holds {} at pixel ({}, {})",
                mask[i],
                i % size.x as usize,
                i / size.x as usize
            );
            Err(Invalid::new(what, why, "compare visibilities from 0 to 1"))
        }
    }
}

fn check_len(what: &str, size: UVec2, len: usize) -> Result<(), Invalid> {
    if len == size.x as usize * size.y as usize && len > 0 {
        return Ok(());
    }
    let why = format!("holds {len} values for {} x {} pixels", size.x, size.y);
    Err(Invalid::new(
        what,
        why,
        "compare images of one size, at least one pixel large",
    ))
}

#[cfg(test)]
mod tests;
