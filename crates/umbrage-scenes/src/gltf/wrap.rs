//! Wrapping of alpha tests. Alpha tests repeat ([`AlphaCutout`](umbrage_core::AlphaCutout)). The
//! format's samplers may clamp or mirror instead, which is equivalent only if a mesh stays within
//! its texture, or finds the same alpha beyond it.

use super::budget::ReadBudget;
use gltf::texture::WrappingMode;
use std::collections::BTreeSet;
use umbrage_core::glam::Vec2;
use umbrage_core::{AlphaCutout, Invalid, Texture};

/// Tolerance for coordinates outside a texture, texels. Exporters round coordinates, and those of
/// 16 bits have an error of half of 2^-16, which is 1/16 of a texel for a texture 8,192 texels
/// wide.
const ROUNDING: f64 = 0.125;

/// Wrapping of a texture along u and along v.
pub(super) type Wraps = [WrappingMode; 2];

/// Returns an error if a mesh shows other holes with a repeated texture than with `wraps`.
pub(super) fn check(
    uvs: &[Vec2],
    wraps: Wraps,
    texture: &Texture,
    alpha: &AlphaCutout,
    budget: &mut ReadBudget,
) -> Result<(), Invalid> {
    if wraps == [WrappingMode::Repeat; 2] {
        return Ok(());
    }
    let low = uvs.iter().copied().reduce(Vec2::min).unwrap_or(Vec2::ZERO);
    let high = uvs.iter().copied().reduce(Vec2::max).unwrap_or(Vec2::ZERO);
    let size = texture.size;
    let columns = texels(low.x, high.x, size.x, wraps[0]);
    let rows = texels(low.y, high.y, size.y, wraps[1]);
    let is_found = |[found, requested]: &[i64; 2]| found == requested;
    if columns.iter().all(is_found) && rows.iter().all(is_found) {
        return Ok(());
    }
    // Many meshes may check one large image.
    budget.decode(columns.len() as u64 * rows.len() as u64)?;
    let is_hole = |x: i64, y: i64| {
        let texel = texture.texels.get((y * i64::from(size.x) + x) as usize);
        texel[3] < alpha.cutoff
    };
    let is_alike = |&[row, requested_row]: &[i64; 2]| {
        columns
            .iter()
            .all(|&[column, requested]| is_hole(column, row) == is_hole(requested, requested_row))
    };
    if rows.iter().all(is_alike) {
        return Ok(());
    }
    Err(Invalid::new(
        "alpha mask",
        "exceeds its texture, which is clamped or mirrored there; alpha tests repeat here, and would differ",
        "keep texture coordinates within 0 to 1, or draw the mirrored part into the image",
    ))
}

/// Returns the texels that a mesh shows along one axis, as pairs: the texel of a repeated texture,
/// and that of `wrap`.
fn texels(low: f32, high: f32, count: u32, wrap: WrappingMode) -> BTreeSet<[i64; 2]> {
    let count_real = f64::from(count);
    let first = (f64::from(low) * count_real + ROUNDING).floor() as i64;
    // Include at least one: a mesh may show a line of its texture.
    let end = (f64::from(high) * count_real - ROUNDING).ceil() as i64;
    let last = end.saturating_sub(1).max(first);
    let count = i64::from(count);
    let requested = |i: i64| match wrap {
        WrappingMode::Repeat => i.rem_euclid(count),
        WrappingMode::ClampToEdge => i.clamp(0, count - 1),
        WrappingMode::MirroredRepeat => {
            let i = i.rem_euclid(2 * count);
            i.min(2 * count - 1 - i)
        }
    };
    // All further pairs are repetitions: of mirrored textures after two, of clamped ones after one
    // on either side.
    let shown = |i: &i64| (first..=last).contains(i);
    let parts = [
        first..=last.min(first.saturating_add(2 * count)),
        first.max(last.saturating_sub(2 * count))..=last,
        0..=count - 1,
    ];
    let all = parts.into_iter().flatten().filter(shown);
    all.map(|i| [i.rem_euclid(count), requested(i)]).collect()
}
