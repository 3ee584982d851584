//! How a triangle's depths are merged into a row of pixels, [`LANES`] at a time.
//!
//! One type per mode, so that each gets its own loops. All loops are plain, so that the compiler
//! can vectorise them.

use crate::raster::tile::{LANES, TileBuffer};

/// What an image keeps of what is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mode {
    /// The least depth.
    Depth,
    /// The least depth, and the id of its triangle.
    DepthWithIds,
    /// The least depth, in steps of 1/65535.
    Depth16,
    /// The least of the depths beyond another image's.
    DepthPeel,
    /// The same, both in steps of 1/65535.
    DepthPeel16,
    /// Back faces minus front faces that are at or behind another image's depth, modulo 256
    /// (depth-fail count).
    StencilDepthFail,
}

impl Mode {
    /// Returns what every texel of a cleared image holds.
    pub(crate) const fn clear_value(self) -> f32 {
        if matches!(self, Self::StencilDepthFail) {
            0.0
        } else {
            1.0
        }
    }

    /// Whether it writes ids.
    pub(crate) const fn has_ids(self) -> bool {
        matches!(self, Self::DepthWithIds)
    }

    /// Whether it reads another image.
    pub(crate) const fn reads_other_image(self) -> bool {
        matches!(
            self,
            Self::DepthPeel | Self::DepthPeel16 | Self::StencilDepthFail
        )
    }

    /// Whether the image holds depths in fixed point, where one unit of polygon offset is the same
    /// for all triangles.
    pub(crate) const fn is_fixed_point(self) -> bool {
        matches!(self, Self::Depth16 | Self::DepthPeel16)
    }
}

/// What a mode writes or reads besides `stored`: slices that begin at the first lane.
pub(crate) struct TileAttachments<'a> {
    /// Triangle ids if [`Mode::has_ids`], else empty.
    pub(crate) ids: &'a mut [u32],
    /// The other image's texels if [`Mode::reads_other_image`], else empty.
    pub(crate) other: &'a [f32],
}

/// A mode's loops over the lanes of a row.
pub(crate) trait DepthOp {
    /// The mode.
    const MODE: Mode;

    /// Draws the depths `z` (0..=1) over `stored`.
    ///
    /// `outside` is negative in the lanes that lie outside the triangle.
    /// Where `outside` is negative, `z` is 1, which never is nearer than what is stored.
    /// `tag` is [`Record::tag`](crate::raster::record::Record::tag).
    fn write(
        stored: &mut [f32; LANES],
        attachments: TileAttachments<'_>,
        z: &[f32; LANES],
        outside: &[i32; LANES],
        tag: u32,
    );

    /// Runs after some triangles were drawn into a tile.
    fn finish_tile(_: &mut TileBuffer) {}
}

/// The loops of [`Mode::Depth`].
pub(crate) struct Depth;
/// The loops of [`Mode::DepthWithIds`].
pub(crate) struct DepthWithIds;
/// The loops of [`Mode::Depth16`].
pub(crate) struct Depth16;
/// The loops of [`Mode::DepthPeel`].
pub(crate) struct DepthPeel;
/// The loops of [`Mode::DepthPeel16`].
pub(crate) struct DepthPeel16;
/// The loops of [`Mode::StencilDepthFail`].
pub(crate) struct StencilDepthFail;

impl DepthOp for Depth {
    const MODE: Mode = Mode::Depth;

    #[inline(always)]
    fn write(
        stored: &mut [f32; LANES],
        _: TileAttachments<'_>,
        z: &[f32; LANES],
        _: &[i32; LANES],
        _: u32,
    ) {
        keep_least(stored, z);
    }
}

impl DepthOp for DepthWithIds {
    const MODE: Mode = Mode::DepthWithIds;

    /// Of equal depths the lower id is kept, since triangles come in any order and the first one
    /// must win. Depth 1 writes no id, since the image is cleared to it.
    #[inline(always)]
    fn write(
        stored: &mut [f32; LANES],
        attachments: TileAttachments<'_>,
        z: &[f32; LANES],
        _: &[i32; LANES],
        tag: u32,
    ) {
        let Some(ids) = attachments.ids.first_chunk_mut::<LANES>() else {
            return;
        };
        for i in 0..LANES {
            let nearer = (z[i] < stored[i]) | ((z[i] == stored[i]) & (tag < ids[i]) & (z[i] < 1.0));
            ids[i] = if nearer { tag } else { ids[i] };
        }
        keep_least(stored, z);
    }
}

impl DepthOp for Depth16 {
    const MODE: Mode = Mode::Depth16;

    /// Compares stored floats instead of steps, since both have the same order.
    #[inline(always)]
    fn write(
        stored: &mut [f32; LANES],
        _: TileAttachments<'_>,
        z: &[f32; LANES],
        _: &[i32; LANES],
        _: u32,
    ) {
        keep_least(stored, &z.map(stored16));
    }
}

impl DepthOp for DepthPeel {
    const MODE: Mode = Mode::DepthPeel;

    #[inline(always)]
    fn write(
        stored: &mut [f32; LANES],
        attachments: TileAttachments<'_>,
        z: &[f32; LANES],
        _: &[i32; LANES],
        _: u32,
    ) {
        keep_beyond(stored, attachments, z);
    }
}

impl DepthOp for DepthPeel16 {
    const MODE: Mode = Mode::DepthPeel16;

    /// The other image holds whole steps, too: a depth that was drawn there equals it after
    /// rounding, and isn't behind it.
    #[inline(always)]
    fn write(
        stored: &mut [f32; LANES],
        attachments: TileAttachments<'_>,
        z: &[f32; LANES],
        _: &[i32; LANES],
        _: u32,
    ) {
        keep_beyond(stored, attachments, &z.map(stored16));
    }
}

impl DepthOp for StencilDepthFail {
    const MODE: Mode = Mode::StencilDepthFail;

    /// Sums of floats are exact in any order, since counts are whole numbers far below 2^24.
    #[inline(always)]
    fn write(
        stored: &mut [f32; LANES],
        attachments: TileAttachments<'_>,
        z: &[f32; LANES],
        outside: &[i32; LANES],
        tag: u32,
    ) {
        let Some(other) = attachments.other.first_chunk::<LANES>() else {
            return;
        };
        let change = tag as i32 as f32; // +1 for a back face, -1 for a front face
        for i in 0..LANES {
            let passes_depth_test = z[i] < other[i];
            let is_outside = outside[i] < 0;
            stored[i] += if passes_depth_test | is_outside {
                0.0
            } else {
                change
            };
        }
    }

    /// Wraps the counts, modulo 256.
    fn finish_tile(buffer: &mut TileBuffer) {
        for count in &mut buffer.texels {
            *count -= 256.0 * (*count / 256.0).floor();
        }
    }
}

/// Keeps the lesser depth in each lane.
///
/// Compares bits, whose order is that of positive floats.
/// For a comparison of floats the compiler may emit masked stores, which are slow on many
/// processors.
#[inline(always)]
fn keep_least(stored: &mut [f32; LANES], z: &[f32; LANES]) {
    for i in 0..LANES {
        stored[i] = f32::from_bits(z[i].to_bits().min(stored[i].to_bits()));
    }
}

/// Keeps the lesser depth in each lane where `z` is beyond the other image's depth.
#[inline(always)]
fn keep_beyond(stored: &mut [f32; LANES], attachments: TileAttachments<'_>, z: &[f32; LANES]) {
    let Some(other) = attachments.other.first_chunk::<LANES>() else {
        return;
    };
    let mut beyond = [1.0; LANES];
    for i in 0..LANES {
        beyond[i] = if z[i] > other[i] { z[i] } else { 1.0 };
    }
    keep_least(stored, &beyond);
}

/// Returns what is read back from a 16-bit depth image into which `z` (0..=1) was drawn.
#[inline(always)]
pub(crate) fn stored16(z: f32) -> f32 {
    // The spacing of floats from 128 to 256 is 2^-16: the sum's low bits hold z * 65535, rounded to
    // nearest, ties to even.
    const MAGIC: f32 = 128.0;
    let steps = (z * (65_535.0 / 65_536.0) + MAGIC).to_bits() - MAGIC.to_bits();
    steps as f32 * (1.0 / 65_535.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sixteen_bits_hold_every_step_and_both_ends() {
        assert_eq!((stored16(0.0), stored16(1.0)), (0.0, 1.0));
        for step in 0..=65_535_u32 {
            // Twice drawn is once drawn, and the value is within half a step of f32 of the step's
            // own.
            let z = (f64::from(step) / 65_535.0) as f32;
            assert!((stored16(z) - z).abs() <= f32::EPSILON * z, "{step}");
            assert_eq!(stored16(stored16(z)), stored16(z), "{step}");
        }
        assert!(stored16(0.4999 / 65_535.0) == 0.0 && stored16(0.5001 / 65_535.0) > 0.0);
    }
}
