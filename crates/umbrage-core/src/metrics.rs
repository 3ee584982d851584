//! Image metrics: a mask's error against truth, and the agreement of two masks.
//!
//! Masks hold visibility 0..=1, rows from the top. Every comparison rejects masks of the wrong
//! size, and masks with NaN or values outside 0..=1.

mod causes;

pub use crate::metrics::causes::{CONTACT, Cause, Causes, TruthImage, attribute, is_penumbra};

use crate::invalid::Invalid;
use glam::UVec2;

/// Threshold for a **false shadow** (mask darker than truth by more than this) and **false light**
/// (mask lighter by more): a quarter of the light, a clearly visible step. For hard masks and ideal
/// lights any threshold in 0..1 gives the same figures.
pub const ERROR_THRESHOLD: f32 = 0.25;

/// Distance from any true shadow edge beyond which a false shadow is **acne**, in pixels between
/// centres.
pub const ACNE_DISTANCE: u32 = 8;

/// Lower bound of penumbra in truth; the upper bound is one less it. Penumbra counts as a shadow
/// edge.
pub const PENUMBRA: f32 = 0.02;

/// Tolerance for decided pixels of two masks: one step of an 8-bit image.
pub const AGREEMENT_TOLERANCE: f32 = 1.0 / 255.0;

/// Class of a pixel for the error figures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Pixel {
    /// Counted in the errors.
    #[default]
    Counted,
    /// No visible geometry, or a surface that receives no shadows.
    Empty,
    /// Faces away from the light, or is outside a spot's cone: shading darkens it in any case.
    Unlit,
    /// Truth is numerically ambiguous at this pixel.
    Ambiguous,
    /// The mask's backend sees a different triangle than truth, because its device snaps vertices
    /// to a different grid.
    Elsewhere,
    /// Not in the judged sample of the pixels. Truth is a preview here.
    Unsampled,
}

impl Pixel {
    /// Returns whether the pixel counts, or would count if it were in the judged sample.
    pub fn is_candidate(self) -> bool {
        matches!(self, Self::Counted | Self::Unsampled)
    }
}

/// Error of a mask against truth. Shares are percentages of the counted pixels, 0..=100; all
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
    /// Pixels where the mask is darker than truth by more than [`ERROR_THRESHOLD`], percent.
    pub false_shadow: f64,
    /// Pixels where the mask is lighter than truth by more than [`ERROR_THRESHOLD`], percent.
    pub false_light: f64,
    /// False shadow farther than [`ACNE_DISTANCE`] from any true shadow edge, percent.
    pub acne: f64,
    /// Pixels counted.
    pub counted: u64,
    /// Excluded pixels: truth is ambiguous.
    pub ambiguous: u64,
    /// Excluded pixels that face away from the light or are outside its cone.
    pub unlit: u64,
    /// Excluded pixels: the backend sees a different triangle than truth.
    #[cfg_attr(feature = "serde", serde(default))]
    pub elsewhere: u64,
    /// Excluded pixels that are not in the judged sample.
    #[cfg_attr(feature = "serde", serde(default))]
    pub unsampled: u64,
    /// Standard error of `rmse` due to sampling; 0 if all pixels are judged. It is also 0, and no
    /// bound, if fewer than two pixels are judged or none of them is wrong.
    #[cfg_attr(feature = "serde", serde(default))]
    pub rmse_error: f64,
}

/// Truth, prepared for comparison with many masks.
#[derive(Clone, Debug)]
pub struct ReferenceMask<'a> {
    size: UVec2,
    truth: &'a [f32],
    pixels: &'a [Pixel],
    is_near_edge: Vec<bool>,
}

impl<'a> ReferenceMask<'a> {
    /// Finds truth's shadow edges; `pixels` holds the class of each pixel. A true shadow edge is a
    /// penumbra pixel, or one that differs from one of its four neighbours by more than
    /// [`ERROR_THRESHOLD`]. Pixels that are [`Pixel::Empty`] make no edges.
    ///
    /// # Errors
    /// Errors if sizes differ or a value is not within 0..=1.
    pub fn new(size: UVec2, truth: &'a [f32], pixels: &'a [Pixel]) -> Result<Self, Invalid> {
        check("truth", size, truth)?;
        check_len("pixel classes", size, pixels.len())?;
        let is_near_edge = pixels_near(size, &edges(size, truth, pixels), ACNE_DISTANCE);
        Ok(Self {
            size,
            truth,
            pixels,
            is_near_edge,
        })
    }

    /// Returns the same truth with other pixel classes, for another backend; shadow edges are kept.
    ///
    /// # Errors
    /// Errors if the number of classes is not the number of pixels.
    pub fn with_pixels<'b>(&'b self, pixels: &'b [Pixel]) -> Result<ReferenceMask<'b>, Invalid> {
        check_len("pixel classes", self.size, pixels.len())?;
        Ok(ReferenceMask {
            pixels,
            ..self.clone()
        })
    }

    /// Computes the error of a mask against this truth.
    ///
    /// # Errors
    /// Errors if sizes differ or a value is not within 0..=1.
    pub fn errors(&self, mask: &[f32]) -> Result<Errors, Invalid> {
        check("mask", self.size, mask)?;
        let mut out = Errors::default();
        let mut sum_of_squares = 0.0;
        let mut sum_of_fourth_powers = 0.0;
        for (i, pixel) in self.pixels.iter().enumerate() {
            match pixel {
                Pixel::Counted => {
                    out.add(mask[i], self.truth[i], self.is_near_edge[i]);
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
    /// Compares one mask with truth. To compare many, use a [`ReferenceMask`].
    ///
    /// # Errors
    /// Errors if sizes differ or a value is not within 0..=1.
    pub fn measure(
        size: UVec2,
        mask: &[f32],
        truth: &[f32],
        pixels: &[Pixel],
    ) -> Result<Self, Invalid> {
        ReferenceMask::new(size, truth, pixels)?.errors(mask)
    }

    /// Returns the standard error of the root of `mean_square`, given the mean of the fourth
    /// powers. It is that of a mean of `counted` out of a finite number of pixels (Cochran 1977,
    /// "Sampling techniques", 2.6), propagated through the root to first order. Pixels are drawn
    /// one from each block, which errs less than pixels drawn at random.
    fn rmse_error_of(&self, mean_square: f64, mean_fourth_power: f64) -> f64 {
        if self.unsampled == 0 || self.counted < 2 || mean_square == 0.0 {
            return 0.0;
        }
        let counted = self.counted as f64;
        let share_left_out = self.unsampled as f64 / (counted + self.unsampled as f64);
        // The sample estimate of a population's variance has one degree of freedom less.
        let variance = (mean_fourth_power - mean_square * mean_square).max(0.0);
        let error_of_mean = (variance / (counted - 1.0) * share_left_out).sqrt();
        error_of_mean / (2.0 * mean_square.sqrt())
    }

    /// Adds one pixel to the sums.
    fn add(&mut self, mask: f32, truth: f32, is_near_edge: bool) {
        let difference = mask - truth;
        self.counted += 1;
        self.mean += f64::from(difference.abs());
        self.bias += f64::from(difference);
        self.largest = self.largest.max(f64::from(difference.abs()));
        if difference < -ERROR_THRESHOLD {
            self.false_shadow += 1.0;
            self.acne += if is_near_edge { 0.0 } else { 1.0 };
        }
        if difference > ERROR_THRESHOLD {
            self.false_light += 1.0;
        }
    }
}

/// Returns the pixels on true shadow edges, as [`Errors::measure`] defines them.
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

/// Returns whether each pixel is within `distance` (Euclidean, between centres, in pixels) of a set
/// pixel: an exact distance transform cut off at `distance`, columns first, then rows.
pub fn pixels_near(size: UVec2, set: &[bool], distance: u32) -> Vec<bool> {
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
        // Scan down from the last set pixel above, then up from the last set pixel below.
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

/// Reason why two masks may differ at a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Doubt {
    /// The masks must agree: the result is decided.
    #[default]
    None,
    /// Rounding decides the result.
    Rounding,
    /// The backends see different triangles.
    Triangle,
}

/// Greatest share of the compared pixels that may differ because of rounding. Rounding decides
/// along texel edges and at self-shadowing; a larger share could hide a bug in the bias or the
/// light space.
pub const MAX_UNDECIDED_SHARE: f64 = 0.001;

/// Greatest increase of a mask's RMSE against truth due to a device's rounding
/// ([`Agreement::excess`]). A bias that is too small darkens whole surfaces, which adds tenths;
/// edges that move by a part of a pixel add thousandths.
pub const MAX_EXCESS_RMSE: f64 = 0.005;

/// Agreement of a mask with the CPU's mask of the same view.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Agreement {
    /// Pixels compared.
    pub compared: u64,
    /// Pixels that are not bit-equal.
    pub differing: u64,
    /// Pixels that differ by more than the tolerance, excused by [`Doubt::Rounding`].
    pub undecided: u64,
    /// Pixels that differ by more than the tolerance, excused by [`Doubt::Triangle`].
    pub elsewhere: u64,
    /// Greatest difference anywhere, 0..=1.
    pub largest: f64,
    /// Decided pixels that differ by more than [`AGREEMENT_TOLERANCE`]: must be 0.
    pub violations: u64,
    /// Pixels at which the CPU's own mask changes by more than the tolerance when it rounds
    /// vertices as the other backend's device does ([`Snapping`](crate::Snapping)). There the other
    /// backend must agree with the changed mask.
    #[cfg_attr(feature = "serde", serde(default))]
    pub by_grid: u64,
    /// RMSE of the mask against truth, minus that of the CPU's mask over the same pixels; 0 if not
    /// measured.
    #[cfg_attr(feature = "serde", serde(default))]
    pub excess: f64,
}

impl Agreement {
    /// Compares two masks. `doubts` marks the pixels that may differ. `tolerance` is the kernel's
    /// allowance beyond [`AGREEMENT_TOLERANCE`], 0..=1; for example, comparison samplers' weights
    /// are device-dependent.
    ///
    /// # Errors
    /// Errors if sizes differ or a value is not within 0..=1.
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

    /// Returns whether all decided pixels agree.
    pub fn holds(&self) -> bool {
        self.violations == 0
    }

    /// Returns whether the mask's error exceeds the CPU's by at most [`MAX_EXCESS_RMSE`].
    pub fn is_accurate(&self) -> bool {
        self.excess <= MAX_EXCESS_RMSE
    }

    /// Returns whether rounding excuses at most [`MAX_UNDECIDED_SHARE`] of the pixels.
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
