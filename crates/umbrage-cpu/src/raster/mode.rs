//! Merging of a triangle's depths into a row of pixels, [`LANES`] at a time.
//!
//! Each mode has its own type, and so its own loops. All loops are simple, so that the compiler can
//! vectorise them.

use crate::raster::tile::{LANES, TileBuffer};

/// Test and update of an image when triangles are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mode {
    /// Keeps the least depth.
    Depth,
    /// Keeps the least depth, and the id of its triangle.
    DepthWithIds,
    /// Keeps the least depth, in steps of 1/65535.
    Depth16,
    /// Keeps the least of the depths beyond another image's.
    DepthPeel,
    /// Keeps the least of the depths beyond another image's, both in steps of 1/65535.
    DepthPeel16,
    /// Counts back faces minus front faces that are at or behind another image's depth, modulo 256
    /// (depth-fail count).
    StencilDepthFail,
}

impl Mode {
    /// Returns the value of every texel of a cleared image.
    pub(crate) const fn clear_value(self) -> f32 {
        if matches!(self, Self::StencilDepthFail) {
            0.0
        } else {
            1.0
        }
    }

    /// Returns whether it writes ids.
    pub(crate) const fn has_ids(self) -> bool {
        matches!(self, Self::DepthWithIds)
    }

    /// Returns whether it reads another image.
    pub(crate) const fn reads_other_image(self) -> bool {
        matches!(
            self,
            Self::DepthPeel | Self::DepthPeel16 | Self::StencilDepthFail
        )
    }

    /// Returns whether the image stores fixed-point depths, for which one unit of polygon offset is
    /// the same for all triangles.
    pub(crate) const fn is_fixed_point(self) -> bool {
        matches!(self, Self::Depth16 | Self::DepthPeel16)
    }
}

/// Attachments other than `stored` that a mode writes or reads: slices that begin at the first
/// lane.
pub(crate) struct TileAttachments<'a> {
    /// Triangle ids if [`Mode::has_ids`], otherwise empty.
    pub(crate) ids: &'a mut [u32],
    /// Texels of the other image if [`Mode::reads_other_image`], otherwise empty.
    pub(crate) other: &'a [f32],
}

/// Loops of a mode over the lanes of a row.
pub(crate) trait DepthOp {
    /// The mode.
    const MODE: Mode;

    /// Draws the depths `z` (0..=1) over `stored`.
    ///
    /// `outside` is negative in the lanes outside the triangle.
    /// There, `z` is 1, which is never closer than the stored depth.
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

/// Loops of [`Mode::Depth`].
pub(crate) struct Depth;
/// Loops of [`Mode::DepthWithIds`].
pub(crate) struct DepthWithIds;
/// Loops of [`Mode::Depth16`].
pub(crate) struct Depth16;
/// Loops of [`Mode::DepthPeel`].
pub(crate) struct DepthPeel;
/// Loops of [`Mode::DepthPeel16`].
pub(crate) struct DepthPeel16;
/// Loops of [`Mode::StencilDepthFail`].
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

    /// Keeps the lower id at equal depths, since triangles arrive in any order and the first one
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

    /// Compares whole steps, as in the other image: a depth that was drawn there is equal after
    /// rounding, and not beyond it.
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

    /// Adds floats, which is exact in any order, since counts are whole numbers far below 2^24.
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
/// Compares bits, whose order is that of positive floats. For a comparison of floats, the compiler
/// may emit masked stores, which are slow on many processors.
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

/// Returns the value read back from a 16-bit depth image after `z` (0..=1) was drawn.
#[inline(always)]
pub(crate) fn stored16(z: f32) -> f32 {
    // The spacing of floats from 128 to 256 is 2^-16, so the sum's low bits are z * 65535, rounded
    // to nearest, ties to even.
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
            // Drawing twice equals drawing once, and the value is within half a step of f32 of the
            // exact step.
            let z = (f64::from(step) / 65_535.0) as f32;
            assert!((stored16(z) - z).abs() <= f32::EPSILON * z, "{step}");
            assert_eq!(stored16(stored16(z)), stored16(z), "{step}");
        }
        assert!(stored16(0.4999 / 65_535.0) == 0.0 && stored16(0.5001 / 65_535.0) > 0.0);
    }
}
